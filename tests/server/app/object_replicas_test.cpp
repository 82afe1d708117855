#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "server/objects/object_error.h"
#include "server/objects/object_store.h"
#include "tests/server/app/replica.h"
#include "tests/server/fixtures/postgres_cluster.h"
#include "tests/server/fixtures/swift_service.h"
#include "tests/server/fixtures/test_maps.h"

// Two processes of the server on one database and one object store of map files.
namespace dcloc::server {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using Clock = std::chrono::steady_clock;

class ObjectReplicasTest : public ::testing::Test {
 protected:
  void SetUp() override {
    DCLOC_SKIP_WITHOUT_POSTGRES();
    DCLOC_SKIP_WITHOUT_SWIFT();
    options_ = SwiftService::Get().NewOptions();
    database_ = PostgresCluster::Get().NewDatabase();
    a_ = Start("a");
    b_ = Start("b");
  }

  std::unique_ptr<Replica> Start(const std::string& name) const {
    return std::make_unique<Replica>(
        folder_.path(), name,
        std::vector<std::string>{"--catalogue", database_, "--map-files", options_.location,
                                 "--object-endpoint", options_.endpoint, "--object-credentials",
                                 options_.credentials_file, "--object-ca", options_.ca_file,
                                 "--object-timeout-ms", "500"});
  }

  std::size_t ObjectCount() const { return (*ObjectStore::Open(options_))->List("")->size(); }

  template <typename Predicate>
  static bool Within(std::chrono::milliseconds time, Predicate done) {
    const Clock::time_point end = Clock::now() + time;
    while (!done()) {
      if (Clock::now() > end) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return true;
  }

  TemporaryFolder folder_;
  ObjectOptions options_;
  std::string database_;
  std::unique_ptr<Replica> a_, b_;
};

TEST_F(ObjectReplicasTest, AMapThatOneTakesTheOtherServes) {
  const grpc::Status uploaded = a_->Upload(SmallMap());
  ASSERT_TRUE(uploaded.ok()) << uploaded.error_message();
  EXPECT_EQ(ObjectCount(), 1U);
  {
    Vehicle vehicle(*b_);
    ASSERT_TRUE(vehicle.is_open());
    EXPECT_TRUE(vehicle.Localize());
    EXPECT_FALSE(a_->DeleteMap().ok()) << "it is in use";
    vehicle.End();
  }
  EXPECT_TRUE(Within(std::chrono::seconds(10), [&] { return a_->DeleteMap().ok(); }));
  EXPECT_EQ(ObjectCount(), 0U) << "the object goes with its last version";
  EXPECT_TRUE(a_->Terminate());
  EXPECT_TRUE(b_->Terminate());
}

TEST_F(ObjectReplicasTest, AServiceOfAnUnknownAuthorityOrKeyIsRefused) {
  ObjectOptions stranger = options_;
  stranger.ca_file = "";
  const absl::Status unknown = (*ObjectStore::Open(stranger))->List("").status();
  EXPECT_THAT(ObjectStoreReason(unknown), HasSubstr("certificate"));
  const std::string keys = "aws_access_key_id = test:tester\naws_secret_access_key = guess\n";
  stranger = options_;
  stranger.credentials_file = folder_.Write("keys", std::as_bytes(std::span(keys)));
  std::filesystem::permissions(stranger.credentials_file, std::filesystem::perms::owner_read);
  const absl::Status wrong = (*ObjectStore::Open(stranger))->List("").status();
  EXPECT_THAT(ObjectStoreReason(wrong), HasSubstr("403 SignatureDoesNotMatch"));
  options_.location = "s3://no-such-bucket/site";
  EXPECT_THROW(Start("c"), std::runtime_error) << "a server that it would refuse does not start";
}

TEST_F(ObjectReplicasTest, WhileTheStoreIsAwayWhatIsHereGoesOnAndTheRestComesBack) {
  ASSERT_TRUE(a_->Upload(SmallMap()).ok());
  Vehicle first(*b_);
  ASSERT_TRUE(first.is_open() && first.Localize());
  SwiftService::Get().Stop();
  for (int i = 0; i < 20; ++i) {
    const Clock::time_point begin = Clock::now();
    EXPECT_TRUE(first.Localize());
    EXPECT_LT(Clock::now() - begin, std::chrono::seconds(1));
  }
  EXPECT_TRUE(Vehicle(*b_).is_open()) << "in memory";
  first.End();
  b_->Kill();
  b_ = Start("b");
  EXPECT_THAT(b_->Log(), HasSubstr("map files not checked"));
  Vehicle second(*b_);
  EXPECT_TRUE(second.is_open() && second.Localize()) << "from its cache, after a restart";
  Vehicle refused(*a_);
  EXPECT_FALSE(refused.is_open()) << "it has stored the file, and read it never";
  const grpc::Status why = refused.End();
  EXPECT_EQ(why.error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_THAT(why.error_message(), HasSubstr("try again"));
  EXPECT_THAT(why.error_message(), Not(HasSubstr("127.0.0.1")));
  EXPECT_EQ(a_->Upload(SmallMap("other")).error_code(), grpc::StatusCode::UNAVAILABLE);
  SwiftService::Get().Start();
  EXPECT_TRUE(Within(std::chrono::seconds(5), [&] { return Vehicle(*a_).is_open(); }));
  EXPECT_TRUE(a_->Upload(SmallMap("other")).ok());
  EXPECT_TRUE(Within(std::chrono::seconds(5), [&] { return Vehicle(*b_).version() == 2; }));
}

}  // namespace
}  // namespace dcloc::server
