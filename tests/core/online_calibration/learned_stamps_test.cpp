#include "core/online_calibration/learned_stamps.h"

#include <gtest/gtest.h>

#include "core/online_calibration/drive_stamps.h"
#include "tests/core/online_calibration/late_radars.h"

namespace dcloc {
namespace {

RadarModel Described(double offset_s, double sigma_s) {
  return {.id = "front", .time_offset_s = offset_s, .time_offset_sigma_s = sigma_s};
}

constexpr double kVariance = 0.005 * 0.005;

TEST(CorrectedTimeOffsetTest, AMeasuredDelayGoesBeforeADescriptionThatWasNeverCalibrated) {
  const auto offset_s = CorrectedTimeOffset(Described(0.0, 0.02), {0.11, kVariance}, {});
  ASSERT_TRUE(offset_s);
  EXPECT_NEAR(offset_s->value, -0.11, 1e-9);
  EXPECT_NEAR(std::sqrt(offset_s->variance), 0.0158, 1e-4);
}

TEST(CorrectedTimeOffsetTest, ACalibrationStandsUnlessItIsStronglyContradicted) {
  EXPECT_FALSE(CorrectedTimeOffset(Described(-0.06, 0.005), {0.05, kVariance}, {}));
  const auto offset_s = CorrectedTimeOffset(Described(-0.06, 0.005), {0.1, kVariance}, {});
  ASSERT_TRUE(offset_s);
  EXPECT_NEAR(offset_s->value, -0.16, 1e-9);
}

TEST(CorrectedTimeOffsetTest, ASmallDelayCorrectsNothing) {
  EXPECT_FALSE(CorrectedTimeOffset(Described(0.0, 0.1), {0.018, 1e-6}, {}));
}

TEST(CorrectedTimeOffsetTest, WhatIsAssumedGivesWayAsTheDriveTells) {
  const RadarModel described = Described(0.0, 0.02);
  EXPECT_NEAR(CorrectedTimeOffset(described, {0.08, 0.05 * 0.05}, {}, 0.1)->value, -0.09, 1e-9);
  EXPECT_NEAR(CorrectedTimeOffset(described, {0.08, 1e-6}, {}, 0.1)->value, -0.08, 1e-4);
}

LearnedStamps After(double duration_s, LearnedStamps stamps, const Rig& rig = FrontAndRear()) {
  ForEachScan(rig, {.late_s = {0.11, 0.0}}, duration_s, [&](const Scan& scan, std::size_t index) {
    stamps.OnScan(scan.stamp, index, scan, true);
  });
  return stamps;
}

TEST(LearnedStampsTest, ALateRadarIsCorrectedOnceTheMapAllowsIt) {
  LearnedStamps stamps(FrontAndRear(), {});
  EXPECT_FALSE(After(90.0, stamps).time_offset_s(0)) << "nothing has begun";
  stamps.Begin(0.0);
  const LearnedStamps learned = After(90.0, stamps);
  ASSERT_TRUE(learned.time_offset_s(0));
  EXPECT_NEAR(learned.time_offset_s(0)->value, -0.11, 0.006);
  EXPECT_FALSE(learned.time_offset_s(1));
  RigKnowledge known;
  learned.AddTo(known);
  ASSERT_EQ(known.radars.size(), 2U);
  EXPECT_NEAR(known.radars[0].stamp_delay->value, 0.11, 0.006);
  EXPECT_NEAR(known.radars[1].stamp_delay->value, 0.0, 0.006);
}

TEST(LearnedStampsTest, WhatIsKnownIsUsedAtOnceAndCorrectedByTheDrive) {
  RigKnowledge known;
  known.Of("front").stamp_delay = {0.11, 1e-6};
  known.Of("rear").stamp_delay = {0.11, 1e-6};
  LearnedStamps stamps(FrontAndRear(), {});
  stamps.Restore(known);
  RigKnowledge handed_on;
  stamps.AddTo(handed_on);
  EXPECT_EQ(handed_on.radars.size(), 2U) << "it is handed on where it is not used";
  stamps.Begin(0.0);
  ASSERT_TRUE(stamps.time_offset_s(1));
  EXPECT_NEAR(stamps.time_offset_s(1)->value, -0.11, 1e-9);
  const LearnedStamps learned = After(90.0, stamps);
  EXPECT_TRUE(learned.time_offset_s(0));
  EXPECT_FALSE(learned.time_offset_s(1));
}

TEST(LearnedStampsTest, UntilItIsMeasuredARadarCountsAsLateAsThoseOfTheMap) {
  Rig rig = FrontAndRear();
  rig.radars[1].time_offset_sigma_s = 0.005;
  LearnedStamps stamps(rig, {});
  stamps.Begin(0.08);
  ASSERT_TRUE(stamps.time_offset_s(0));
  EXPECT_EQ(stamps.time_offset_s(0)->value, -0.08);
  EXPECT_FALSE(stamps.time_offset_s(1)) << "it is described as well";
  RigKnowledge known;
  stamps.AddTo(known);
  EXPECT_TRUE(known.radars.empty()) << "nothing is learned yet";
  EXPECT_NEAR(After(90.0, stamps, rig).time_offset_s(0)->value, -0.11, 0.006);
}

// Radars are as late as those of the map, and the vehicle's velocity is later still.
TEST(LearnedStampsTest, AVelocityThatIsLaterThanRadarsLeavesThemAsLateAsTheMap) {
  LearnedStamps stamps(FrontAndRear(), {});
  stamps.Begin(0.11);
  const LateDrive drive{.late_s = {0.11, 0.11}, .reported_late_s = 0.15};
  ForEachScan(FrontAndRear(), drive, 90.0, [&](const Scan& scan, std::size_t index) {
    stamps.OnScan(scan.stamp, index, scan, true);
  });
  for (const std::size_t index : {0U, 1U}) {
    EXPECT_NEAR(stamps.time_offset_s(index)->value, -0.11, 0.008);
  }
}

TEST(LearnedStampsTest, ADescriptionToTheLastDigitIsNotDoubted) {
  Rig rig = FrontAndRear();
  for (RadarModel& radar : rig.radars) radar.time_offset_sigma_s = 0.0;
  LearnedStamps stamps(rig, {});
  stamps.Begin(0.1);
  EXPECT_FALSE(After(60.0, stamps, rig).time_offset_s(0));
}

MeasuredStamps MeasuredAfter(double duration_s, const LateDrive& drive) {
  DriveStamps stamps(FrontAndRear());
  ForEachScan(FrontAndRear(), drive, duration_s,
              [&](const Scan& scan, std::size_t) { stamps.Add(scan); });
  return stamps.Measured();
}

TEST(DriveStampsTest, AMapIsMadeByMeasuredStamps) {
  const MeasuredStamps stamps = MeasuredAfter(120.0, {.late_s = {0.11, 0.0}});
  const Rig& rig = stamps.rig;
  EXPECT_NEAR(stamps.mean_delay_s, 0.055, 0.003);
  EXPECT_TRUE(rig.HasKnownStamps());
  EXPECT_NEAR(rig.radars[0].time_offset_s, -0.11, 0.006);
  EXPECT_EQ(rig.radars[1].time_offset_s, 0.0) << "known to be right";
}

TEST(DriveStampsTest, WhatASteadyDriveDoesNotTellStaysAsDescribed) {
  const LateDrive steady{.late_s = {0.11, 0.11},
                         .speed_mps = [](double) { return 14.0; },
                         .yaw_rate_radps = [](double) { return 0.0; }};
  const Rig rig = MeasuredAfter(120.0, steady).rig;
  EXPECT_FALSE(rig.HasKnownStamps());
  EXPECT_EQ(rig.radars[0].time_offset_s, 0.0);
  EXPECT_EQ(rig.radars[0].time_offset_sigma_s, 0.02);
}

}  // namespace
}  // namespace dcloc
