#include "server/passes/pass_tap.h"

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <optional>

#include "server/passes/pass_file.h"
#include "tests/server/fixtures/messages.h"
#include "tests/server/passes/pass_fixture.h"

namespace dcloc::server {
namespace {

class PassTapTest : public ::testing::Test {
 protected:
  PassTapTest() {
    rig_->radars.push_back({.id = "front"});
    writer_.emplace(*passes_.store, passes_.folder.path(), [] { return kWideBounds; });
    v1::Rig message;
    *message.add_radars() = RadarMessage("front");
    tap_ = std::make_unique<PassTap>(*writer_, TownPass(), message);
  }

  /// Scans from number `begin` on, each 77 ms after the one before; `spoil` changes their answers.
  void Drive(int begin, int count, const std::function<void(LocalizedScan&)>& spoil = nullptr) {
    for (int i = begin; i < begin + count; ++i) {
      LocalizedScan answer{.map_version = 1, .rig = rig_};
      answer.localization.state = LocalizationState::kTracking;
      answer.localization.covariance = 0.001 * Matrix6d::Identity();
      answer.localization.quality.inlier_count = 100;
      answer.localization.health.wheel_speed.is_used = true;
      answer.localization.health.yaw_rate.is_used = true;
      answer.localization.health.radars.resize(1);
      answer.localization.health.radars[0].is_used = true;
      if (spoil) spoil(answer);
      tap_->OnLocalized(ScanMessage(i), answer);
    }
  }

  /// Of the passes that were kept, the oldest first.
  std::vector<PassRow> Kept() {
    tap_.reset();
    writer_.reset();
    std::vector<PassRow> rows = passes_.List();
    return {rows.rbegin(), rows.rend()};
  }

  TestPasses passes_;
  const std::shared_ptr<Rig> rig_ = std::make_shared<Rig>();
  std::optional<PassWriter> writer_;
  std::unique_ptr<PassTap> tap_;
};

TEST_F(PassTapTest, KeepsScansWithTheirAnswersOnceTrackingHasSettled) {
  Drive(0, 100);
  const auto kept = Kept();
  ASSERT_EQ(kept.size(), 1U);
  EXPECT_EQ(kept[0].scan_count, 100 - 13) << "the first second does not count";
  EXPECT_EQ(kept[0].first_stamp_ns, ScanMessage(13).stamp_ns());
  EXPECT_EQ(kept[0].last_stamp_ns, ScanMessage(99).stamp_ns());
  ASSERT_TRUE(passes_.store->Fetch(kept[0], passes_.folder.path() / "copy").ok());
  PassFile file(passes_.folder.path() / "copy");
  EXPECT_EQ(file.ReadRig()->radars[0].id, "front");
  Scan scan;
  int count = 0;
  while (*file.Next(&scan)) ++count;
  EXPECT_EQ(count, 87);
  EXPECT_EQ(scan.size(), 20U);
}

TEST_F(PassTapTest, WhatIsNotTrackedSoundAndSureDoesNotCount) {
  Drive(0, 30, [](auto& answer) { answer.localization.state = LocalizationState::kLost; });
  Drive(30, 30, [](auto& answer) { answer.localization.covariance *= 1e4; });
  Drive(60, 30, [](auto& answer) { answer.localization.quality.inlier_count = 5; });
  Drive(90, 30, [](auto& answer) {
    answer.localization.health.radars[0] = {.is_used = false, .fault = SourceFault::kFrozen};
  });
  Drive(120, 30, [](auto& answer) { answer.localization.health.radars.clear(); });
  EXPECT_EQ(writer_->counts().unworthy_scans, 150);
  EXPECT_TRUE(Kept().empty());
  EXPECT_EQ(passes_.FileCount(), 0U);
}

TEST_F(PassTapTest, APassGoesOnWhereItsVehicleLeavesTheMap) {
  const auto lost_at = [](double x_m) {
    return [x_m](LocalizedScan& answer) {
      answer.localization.state = LocalizationState::kLost;
      answer.localization.T_map_vehicle.translation_m.x() = x_m;
    };
  };
  Drive(0, 63);  // 50 of them count
  Drive(63, 5, [](auto& answer) { answer.localization.quality.inlier_count = 5; });
  Drive(68, 30, lost_at(100.0));
  Drive(98, 30, lost_at(501.0));  // further than an update follows
  Drive(128, 30);                 // again in the map; the second before does not count
  const auto kept = Kept();
  ASSERT_EQ(kept.size(), 1U);
  EXPECT_EQ(kept[0].scan_count, 50 + 5 + 30);
  EXPECT_EQ(kept[0].last_stamp_ns, ScanMessage(97).stamp_ns());
}

TEST_F(PassTapTest, AVehicleThatIsLostIsNotFollowedForLong) {
  Drive(0, 63);
  Drive(63, 2'000, [](auto& answer) { answer.localization.state = LocalizationState::kLost; });
  const auto kept = Kept();
  ASSERT_EQ(kept.size(), 1U);
  EXPECT_EQ(kept[0].scan_count, 50 + 1'558) << "two minutes";
}

TEST_F(PassTapTest, WhereARadarIsNotSoundAPassDoesNotGoOn) {
  Drive(0, 63);
  Drive(63, 30, [](auto& answer) {
    answer.localization.health.radars[0] = {.is_used = false, .fault = SourceFault::kFrozen};
  });
  Drive(93, 60, [](auto& answer) { answer.localization.state = LocalizationState::kLost; });
  const auto kept = Kept();
  ASSERT_EQ(kept.size(), 1U) << "none begins beyond the map";
  EXPECT_EQ(kept[0].scan_count, 50);
}

TEST_F(PassTapTest, AGapOfMoreThanASecondAndAnotherVersionBeginAnotherPass) {
  Drive(0, 90);
  Drive(95, 80);   // less than a second is missing
  Drive(195, 80);  // more
  Drive(275, 80, [](auto& answer) { answer.map_version = 2; });
  const auto kept = Kept();
  ASSERT_EQ(kept.size(), 3U);
  EXPECT_EQ(kept[0].scan_count, 77 + 80);
  EXPECT_EQ(kept[1].scan_count, 80);
  EXPECT_EQ(kept[1].map_version, 1);
  EXPECT_EQ(kept[2].map_version, 2);
}

}  // namespace
}  // namespace dcloc::server
