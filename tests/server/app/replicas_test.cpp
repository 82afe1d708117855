#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/identity/postgres_identity_store.h"
#include "server/postgres/postgres_database.h"
#include "tests/server/app/replica.h"
#include "tests/server/fixtures/postgres_cluster.h"
#include "tests/server/fixtures/test_maps.h"
#include "tests/server/fixtures/test_server.h"

// Two processes of the server on one database and one folder of map files.
namespace dcloc::server {
namespace {

using ::testing::HasSubstr;
using Clock = std::chrono::steady_clock;

class ReplicasTest : public ::testing::Test {
 protected:
  void SetUp() override {
    DCLOC_SKIP_WITHOUT_POSTGRES();
    database_ = PostgresCluster::Get().NewDatabase();
    a_ = Start("a");
    b_ = Start("b");
  }

  std::unique_ptr<Replica> Start(const std::string& name) const {
    const std::vector<std::string> arguments = {"--catalogue", database_, "--map-folder",
                                                folder_.path() / "shared"};
    return std::make_unique<Replica>(folder_.path(), name, arguments);
  }

  template <typename Predicate>
  static bool Within(std::chrono::milliseconds time, Predicate done) {
    const Clock::time_point end = Clock::now() + time;
    while (!done()) {
      if (Clock::now() > end) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return true;
  }

  int MapFileCount() const {
    int count = 0;
    for (const auto& entry :
         std::filesystem::recursive_directory_iterator(folder_.path() / "shared")) {
      count += entry.is_regular_file() ? 1 : 0;
    }
    return count;
  }

  TemporaryFolder folder_;
  std::string database_;
  std::unique_ptr<Replica> a_, b_;
};

TEST_F(ReplicasTest, AMapThatOneTakesTheOtherServesAndKeepsFromBeingDeleted) {
  const grpc::Status uploaded = a_->Upload(SmallMap());
  ASSERT_TRUE(uploaded.ok()) << uploaded.error_message();
  Vehicle vehicle(*b_);
  ASSERT_TRUE(vehicle.is_open());
  EXPECT_TRUE(vehicle.Localize());
  const grpc::Status refused = a_->DeleteMap();
  EXPECT_EQ(refused.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_THAT(refused.error_message(), HasSubstr("in use"));
  EXPECT_TRUE(vehicle.Localize());
  vehicle.End();
  EXPECT_TRUE(Within(std::chrono::seconds(10), [&] { return a_->DeleteMap().ok(); }));
  EXPECT_EQ(MapFileCount(), 0) << "the file goes with its last version";
  EXPECT_TRUE(a_->Terminate());
  EXPECT_TRUE(b_->Terminate());
}

TEST_F(ReplicasTest, TheHoldsOfAKilledOneEnd) {
  ASSERT_TRUE(a_->Upload(SmallMap()).ok());
  Vehicle vehicle(*b_);
  ASSERT_TRUE(vehicle.is_open());
  b_->Kill();
  EXPECT_FALSE(a_->DeleteMap().ok()) << "it might only be slow";
  // A lease of 15 s; for that long nobody is taken for dead after a start of the database either.
  EXPECT_TRUE(Within(std::chrono::seconds(25), [&] { return a_->DeleteMap().ok(); }));
}

TEST_F(ReplicasTest, ALabelThatOneSetsHoldsAtTheOtherWithinASecond) {
  ASSERT_TRUE(a_->Upload(SmallMap("first")).ok());
  ASSERT_TRUE(a_->Upload(SmallMap("second")).ok());
  EXPECT_EQ(Vehicle(*b_).version(), 2);
  for (const std::int64_t version : {1, 2, 1}) {
    ASSERT_TRUE(a_->Activate(version).ok());
    std::this_thread::sleep_for(std::chrono::seconds(1));
    EXPECT_EQ(Vehicle(*b_).version(), version);
  }
}

TEST_F(ReplicasTest, ATokenThatIsRevokedIsRefusedByAllWithinASecond) {
  const auto store = *PostgresIdentityStore::Open(*PostgresDatabase::Open({.address = database_}));
  const std::string token = *store->Create(Proof::kToken, {.name = "ops"}, {});
  const std::string admin = *store->Create(Proof::kToken, {.name = "admin"}, {});
  std::this_thread::sleep_for(std::chrono::seconds(1));
  for (Replica* replica : {a_.get(), b_.get()}) {
    EXPECT_EQ(replica->ListMaps(""), grpc::StatusCode::UNAUTHENTICATED);
    EXPECT_EQ(replica->ListMaps(token), grpc::StatusCode::OK);
  }
  ASSERT_TRUE(store->Revoke(1).ok());
  std::this_thread::sleep_for(std::chrono::seconds(1));
  for (Replica* replica : {a_.get(), b_.get()}) {
    EXPECT_EQ(replica->ListMaps(token), grpc::StatusCode::UNAUTHENTICATED);
    EXPECT_EQ(replica->ListMaps(admin), grpc::StatusCode::OK);
  }
}

TEST_F(ReplicasTest, WhileTheDatabaseIsAwayVehiclesDriveOnAndMoreMayCome) {
  ASSERT_TRUE(a_->Upload(SmallMap()).ok());
  const auto store = *PostgresIdentityStore::Open(*PostgresDatabase::Open({.address = database_}));
  const std::string token = *store->Create(Proof::kToken, {.name = "admin"}, {});
  std::this_thread::sleep_for(std::chrono::seconds(1));  // until a token is needed
  Vehicle first(*a_, token);
  ASSERT_TRUE(first.is_open() && first.Localize());
  PostgresCluster::Get().Stop();
  for (int i = 0; i < 30; ++i) {
    const Clock::time_point begin = Clock::now();
    EXPECT_TRUE(first.Localize());
    EXPECT_LT(Clock::now() - begin, std::chrono::seconds(1));
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  Vehicle second(*a_, token);
  EXPECT_TRUE(second.is_open() && second.Localize()) << "its map is in memory, its token known";
  EXPECT_FALSE(Vehicle(*a_, token + "x").is_open());
  v1::DeleteMapRequest request;
  request.set_map_name("town");
  v1::DeleteMapResponse response;
  CallAs call(token);
  const grpc::Status refused = a_->maps->DeleteMap(&call, request, &response);
  EXPECT_EQ(refused.error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_THAT(refused.error_message(), HasSubstr("try again"));
  PostgresCluster::Get().Start();
  EXPECT_TRUE(first.Localize() && second.Localize());
  EXPECT_TRUE(Within(std::chrono::seconds(5), [&] {
    return b_->ListMaps(token) == grpc::StatusCode::OK && Vehicle(*b_, token).is_open();
  }));
}

TEST_F(ReplicasTest, AFolderThatIsGoneIsNotMadeAnew) {
  ASSERT_TRUE(a_->Upload(SmallMap()).ok());
  a_->Kill();
  b_->Kill();
  const std::filesystem::path shared = folder_.path() / "shared";
  std::filesystem::rename(shared, folder_.path() / "unmounted");
  std::filesystem::create_directory(shared);  // where it was mounted
  EXPECT_THROW(Start("a"), std::runtime_error);
  EXPECT_TRUE(std::filesystem::is_empty(shared)) << "the next start must see that too";
  std::filesystem::remove(shared);
  std::filesystem::rename(folder_.path() / "unmounted", shared);
  EXPECT_TRUE(Vehicle(*Start("a")).is_open());
}

TEST_F(ReplicasTest, AStoreOfAnotherCatalogueIsRefused) {
  ASSERT_TRUE(a_->Upload(SmallMap()).ok());
  a_->Kill();
  b_->Kill();
  database_ = PostgresCluster::Get().NewDatabase();
  EXPECT_THROW(Start("a"), std::runtime_error) << "it knows nothing of the files";
  EXPECT_EQ(MapFileCount(), 1);
}

}  // namespace
}  // namespace dcloc::server
