#include "core/online_calibration/learned_rig.h"

#include <gtest/gtest.h>

#include "tests/core/radar/scan_fixture.h"

namespace dcloc {
namespace {

class LearnedRigTest : public ::testing::Test {
 protected:
  // Gives scans of the first radar as it really is; returns how often its mount was corrected.
  int Drive(const RadarModel& real, const EgoVelocity& ego, int scans) {
    int corrections = 0;
    for (int i = 0; i < scans; ++i) {
      stamp_ += std::chrono::milliseconds(200);
      const Scan scan = StaticScan(real, ego, 80, static_cast<unsigned>(++seed_), 1.0);
      corrections += rig_.OnScan(stamp_, 0, scan, ego) ? 1 : 0;
    }
    return corrections;
  }
  static RadarModel Turned(const RadarModel& radar, double yaw_deg) {
    RadarModel turned = radar;
    turned.T_vehicle_radar.rotation =
        Eigen::AngleAxisd(yaw_deg * kRadPerDeg, Eigen::Vector3d::UnitZ()) *
        turned.T_vehicle_radar.rotation;
    return turned;
  }

  const RadarModel described_ = RadarAt("front", 3.6, 0.0, 0.0);
  static EgoVelocity Driving(double speed_mps, double yaw_rate_radps) {
    return {.linear_mps = {speed_mps, 0.0, 0.0},
            .angular_radps = {0.0, 0.0, yaw_rate_radps},
            .covariance = 1e-4 * Matrix6d::Identity()};
  }

  const EgoVelocity straight_ = Driving(14.0, 0.0);
  LearnedRig rig_{Rig{{described_, RadarAt("rear", -1.0, 0.0, 3.14)}}, {}};
  Stamp stamp_{std::chrono::seconds(1)};
  int seed_ = 0;
};

TEST_F(LearnedRigTest, ARightMountIsNotTouched) {
  EXPECT_EQ(Drive(described_, straight_, 100), 0);
  EXPECT_TRUE(
      rig_.rig().radars[0].T_vehicle_radar.rotation.isApprox(described_.T_vehicle_radar.rotation));
  EXPECT_EQ(rig_.FaultOf(0, stamp_), SourceFault::kNone);
}

RigKnowledge Known(double yaw_deg) {
  RigKnowledge known;
  known.Of("front").mount_yaw_error = {yaw_deg * kRadPerDeg, 1e-9};
  known.Of("of another vehicle").mount_yaw_error = {0.1, 1e-9};
  return known;
}

TEST_F(LearnedRigTest, WhatIsKnownIsConfirmedByTheFirstScan) {
  rig_.Restore(Known(7.0));
  EXPECT_TRUE(
      rig_.rig().radars[0].T_vehicle_radar.rotation.isApprox(described_.T_vehicle_radar.rotation))
      << "nothing is corrected before a scan agrees";
  EXPECT_EQ(Drive(Turned(described_, 7.0), straight_, 1), 1);
  RigKnowledge learned;
  rig_.AddTo(learned);
  ASSERT_EQ(learned.radars.size(), 1U);
  EXPECT_NEAR(learned.radars[0].mount_yaw_error->value, 7.0 * kRadPerDeg, 0.5 * kRadPerDeg);
}

TEST_F(LearnedRigTest, WhatIsKnownWronglyIsGivenUp) {
  rig_.Restore(Known(15.0));
  Drive(described_, straight_, 20);
  EXPECT_LT(rig_.rig().radars[0].T_vehicle_radar.rotation.angularDistance(
                described_.T_vehicle_radar.rotation),
            0.6 * kRadPerDeg);
  EXPECT_TRUE(rig_.IsUsable(0, stamp_));
}

TEST_F(LearnedRigTest, ATurnedMountIsCorrectedAndReported) {
  const RadarModel real = Turned(described_, 7.0);
  EXPECT_GE(Drive(real, straight_, 10), 1);
  EXPECT_LT(
      rig_.rig().radars[0].T_vehicle_radar.rotation.angularDistance(real.T_vehicle_radar.rotation),
      0.6 * kRadPerDeg);
  EXPECT_TRUE(rig_.IsUsable(0, stamp_));
  EXPECT_EQ(rig_.FaultOf(0, stamp_), SourceFault::kMount);
  EXPECT_EQ(rig_.FaultOf(1, stamp_), SourceFault::kNone);
}

TEST_F(LearnedRigTest, AMountThatIsMendedIsAsDescribedAgain) {
  Drive(Turned(described_, 7.0), straight_, 10);
  Drive(described_, straight_, 40);
  EXPECT_EQ(rig_.FaultOf(0, stamp_), SourceFault::kNone);
}

TEST_F(LearnedRigTest, ARadarThatLooksElsewhereIsSetAside) {
  Drive(Turned(described_, 60.0), straight_, 10);
  EXPECT_FALSE(rig_.IsUsable(0, stamp_));
  EXPECT_EQ(rig_.FaultOf(0, stamp_), SourceFault::kMount);
}

TEST_F(LearnedRigTest, RangesAreCorrectedBesideTheirDescription) {
  rig_.CorrectRange(0, ScalarEstimate{0.3, 0.04});
  EXPECT_NEAR(rig_.rig().radars[0].range_bias_m, described_.range_bias_m + 0.3, 1e-12);
  EXPECT_NEAR(rig_.rig().radars[0].range_bias_sigma_m, 0.2, 1e-12);
  EXPECT_EQ(rig_.FaultOf(0, stamp_), SourceFault::kNone);
  rig_.CorrectRange(0, ScalarEstimate{-0.8, 0.04});
  EXPECT_EQ(rig_.FaultOf(0, stamp_), SourceFault::kMount);
  rig_.CorrectRange(0, std::nullopt);
  EXPECT_EQ(rig_.rig().radars[0].range_bias_m, described_.range_bias_m);
  EXPECT_EQ(rig_.FaultOf(0, stamp_), SourceFault::kNone);
}

}  // namespace
}  // namespace dcloc
