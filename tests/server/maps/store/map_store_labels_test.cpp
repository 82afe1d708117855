#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>

#include "tests/server/maps/store/map_store_fixture.h"

// Which sessions get which version, and what of it is in memory.
namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

class MapLabelsTest : public StoreFixture {
 protected:
  explicit MapLabelsTest(MapStoreOptions options = {}) : StoreFixture(options) {
    Put(first_);
    Put(second_, /*activate=*/false);
  }

  std::int64_t VersionFor(int vehicle) {
    return store_->AcquireFor("town", "car-" + std::to_string(vehicle))->record.version;
  }

  /// Whether the version was in memory though nobody used it.
  bool IsWarm(std::int64_t version) { return store_->Acquire("town", version)->was_in_memory; }

  const std::vector<std::byte> first_ = SmallMap("first");
  const std::vector<std::byte> second_ = SmallMap("second");
};

TEST_F(MapLabelsTest, RollingBackGoesToTheVersionBeforeAndAgainForward) {
  EXPECT_EQ(Town().previous_version, 0);
  const absl::Status none = store_->RollBack("town").status();
  EXPECT_EQ(none.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(none.message()), HasSubstr("active before"));
  ASSERT_TRUE(store_->Activate("town", 2).ok());
  EXPECT_EQ(Town().previous_version, 1);
  EXPECT_EQ(store_->RollBack("town")->active_version, 1);
  EXPECT_EQ(Town().previous_version, 2);
  EXPECT_EQ(store_->RollBack("town")->active_version, 2);
  EXPECT_EQ(store_->RollBack("country").status().code(), absl::StatusCode::kNotFound);
}

TEST_F(MapLabelsTest, ActivatingTheActiveOneKeepsThePreviousOne) {
  ASSERT_TRUE(store_->Activate("town", 2).ok());
  ASSERT_TRUE(store_->Activate("town", 2).ok());
  EXPECT_EQ(Town().previous_version, 1);
}

TEST_F(MapLabelsTest, ADeletedVersionIsNotRolledBackTo) {
  ASSERT_TRUE(store_->Activate("town", 2).ok());
  ASSERT_TRUE(store_->DeleteVersion("town", 1).ok());
  EXPECT_EQ(Town().previous_version, 0);
  EXPECT_EQ(store_->RollBack("town").status().code(), absl::StatusCode::kFailedPrecondition);
}

TEST_F(MapLabelsTest, AVersionThatCannotBeLoadedLeavesTheOldOneServing) {
  Reopen();
  std::filesystem::resize_file(FileOf(second_), 100);
  EXPECT_EQ(store_->Activate("town", 2).status().code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(Town().active_version, 1);
  EXPECT_EQ(store_->SetCanary("town", 2, 0.5).status().code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(Town().canary_version, 0);
  EXPECT_EQ(VersionFor(1), 1);
}

TEST_F(MapLabelsTest, ACanaryGetsItsShareOfTheVehiclesAndAlwaysTheSame) {
  ASSERT_TRUE(store_->SetCanary("town", 2, 0.3).ok());
  constexpr int kVehicles = 1000;
  std::vector<std::int64_t> versions;
  versions.reserve(kVehicles);
  for (int i = 0; i < kVehicles; ++i) versions.push_back(VersionFor(i));
  EXPECT_NEAR(static_cast<double>(std::ranges::count(versions, 2)) / kVehicles, 0.3, 0.05);
  Reopen();
  for (int i = 0; i < kVehicles; ++i) ASSERT_EQ(VersionFor(i), versions[i]) << i;
  ASSERT_TRUE(store_->SetCanary("town", 2, 0.6).ok());
  for (int i = 0; i < kVehicles; ++i) {
    if (versions[i] == 2) {
      ASSERT_EQ(VersionFor(i), 2) << "a growing share keeps those it had";
    }
  }
  ASSERT_TRUE(store_->SetCanary("town", 2, 1.0).ok());
  EXPECT_EQ(VersionFor(7), 2);
  EXPECT_EQ(store_->Acquire("town", 0)->record.version, 1) << "lists and downloads see the active";
  ASSERT_TRUE(store_->SetCanary("town", 0, 0.0).ok());
  EXPECT_EQ(VersionFor(7), 1);
}

TEST_F(MapLabelsTest, ACanaryThatCannotBeLoadedAnyMoreLeavesTheActiveOneServing) {
  ASSERT_TRUE(store_->SetCanary("town", 2, 1.0).ok());
  Close();
  std::filesystem::remove(FileOf(second_));
  Reopen();
  EXPECT_EQ(VersionFor(1), 1);
}

TEST_F(MapLabelsTest, TheCanaryIsNeitherTheActiveOneNorDeleted) {
  EXPECT_EQ(store_->SetCanary("town", 1, 0.5).status().code(),
            absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(store_->SetCanary("town", 9, 0.5).status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(store_->SetCanary("country", 0, 0.0).status().code(), absl::StatusCode::kNotFound);
  ASSERT_TRUE(store_->SetCanary("town", 2, 0.5).ok());
  const absl::Status status = store_->DeleteVersion("town", 2);
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_TRUE(store_->Activate("town", 2).ok());
  EXPECT_EQ(Town().canary_version, 0) << "who is active is no canary";
  EXPECT_EQ(Town().canary_share, 0.0);
}

TEST_F(MapLabelsTest, TheActiveVersionAndTheCanaryStayWarm) {
  EXPECT_TRUE(IsWarm(1));
  EXPECT_FALSE(IsWarm(2));
  EXPECT_FALSE(IsWarm(2)) << "nobody gets it";
  ASSERT_TRUE(store_->SetCanary("town", 2, 0.5).ok());
  EXPECT_EQ(store_->loaded_map_count(), 2);
  EXPECT_TRUE(IsWarm(2));
  ASSERT_TRUE(store_->DeleteMap("town").ok()) << "being warm is not being in use";
  EXPECT_EQ(store_->loaded_map_count(), 0);
}

TEST_F(MapLabelsTest, TheOldVersionsMemoryIsReleasedWithItsLastSession) {
  std::shared_ptr<const RadarMap> session = store_->Acquire("town", 1)->map;
  std::shared_ptr<const RadarMap> other_session = session;
  const std::weak_ptr<const RadarMap> old = session;
  ASSERT_TRUE(store_->Activate("town", 2).ok());
  session.reset();
  EXPECT_FALSE(old.expired()) << "a session keeps its version";
  EXPECT_EQ(store_->loaded_map_count(), 2);
  other_session.reset();
  EXPECT_TRUE(old.expired());
  EXPECT_EQ(store_->loaded_map_count(), 1);
}

class ColdMapsTest : public MapLabelsTest {
 protected:
  ColdMapsTest() : MapLabelsTest({.max_warm_bytes = 0}) {}
};

TEST_F(ColdMapsTest, WithoutRoomNothingStaysWarm) {
  EXPECT_FALSE(IsWarm(1));
  EXPECT_FALSE(IsWarm(1));
  EXPECT_EQ(store_->loaded_map_count(), 0);
  EXPECT_EQ(VersionFor(1), 1);
}

}  // namespace
}  // namespace dcloc::server
