#include "core/online_calibration/mount_yaw_estimator.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/radar/scan_fixture.h"

namespace dcloc {
namespace {

EgoVelocity DrivingStraight(double speed_mps) { return {.linear_mps = {speed_mps, 0.0, 0.0}}; }

// What a radar sees that looks `yaw_rad` further to the left than its description says.
Scan SeenByTurned(const RadarModel& described, double yaw_rad, const EgoVelocity& ego,
                  unsigned seed) {
  RadarModel turned = described;
  turned.T_vehicle_radar.rotation =
      Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()) * turned.T_vehicle_radar.rotation;
  return StaticScan(turned, ego, 80, seed, 1.0);
}

class MountYawTest : public ::testing::Test {
 protected:
  void Drive(double yaw_rad, int scans, const EgoVelocity& ego = DrivingStraight(12.0)) {
    for (int i = 0; i < scans; ++i) {
      stamp_ += std::chrono::milliseconds(200);
      estimator_.OnScan(stamp_, SeenByTurned(radar_, yaw_rad, ego, static_cast<unsigned>(++seed_)),
                        radar_, ego, workspace_);
    }
  }

  RadarModel radar_ = RadarAt("front_left", 3.5, 0.7, 0.6);
  MountYawEstimator estimator_{0.5 * kRadPerDeg, {}};
  MountYawWorkspace workspace_;
  Stamp stamp_{std::chrono::seconds(1)};
  int seed_ = 0;
};

TEST_F(MountYawTest, ADescribedMountStaysAsItIs) {
  Drive(0.0, 50);
  EXPECT_NEAR(estimator_.error().value, 0.0, 0.1 * kRadPerDeg);
  EXPECT_LT(std::sqrt(estimator_.error().variance), 0.15 * kRadPerDeg);
}

TEST_F(MountYawTest, AMountDescribedWronglyIsFoundWithinASecond) {
  for (const double yaw_deg : {-90.0, -15.0, -4.0, 3.0, 10.0, 30.0}) {
    estimator_ = MountYawEstimator{0.5 * kRadPerDeg, {}};
    Drive(yaw_deg * kRadPerDeg, 5);
    EXPECT_NEAR(estimator_.error().value, yaw_deg * kRadPerDeg, 0.6 * kRadPerDeg) << yaw_deg;
  }
}

TEST_F(MountYawTest, AKnockIsFoundAfterALongDrive) {
  Drive(0.0, 100);
  Drive(8.0 * kRadPerDeg, 5);
  EXPECT_NEAR(estimator_.error().value, 8.0 * kRadPerDeg, 0.6 * kRadPerDeg);
}

// Off by a share, range rates agree on one side of the view with a mount that looks aside.
TEST_F(MountYawTest, RangeRatesThatAreOffByAShareAreNoKnock) {
  for (const double share : {-0.07, 0.07, 0.2}) {
    estimator_ = MountYawEstimator{0.5 * kRadPerDeg, {}};
    Drive(0.0, 20);
    for (int i = 0; i < 20; ++i) {
      stamp_ += std::chrono::milliseconds(200);
      Scan scan = SeenByTurned(radar_, 0.0, DrivingStraight(9.0), static_cast<unsigned>(++seed_));
      for (float& range_rate_mps : scan.range_rate_mps) {
        range_rate_mps *= static_cast<float>(1.0 + share);
      }
      estimator_.OnScan(stamp_, scan, radar_, DrivingStraight(9.0), workspace_);
    }
    EXPECT_NEAR(estimator_.error().value, 0.0, 0.5 * kRadPerDeg) << share;
  }
}

TEST_F(MountYawTest, CurvesAndSlowDrivesGiveNoReading) {
  Drive(5.0 * kRadPerDeg, 10, DrivingStraight(1.0));
  EgoVelocity curve = DrivingStraight(12.0);
  curve.angular_radps.z() = 0.3;
  Drive(5.0 * kRadPerDeg, 10, curve);
  EXPECT_EQ(estimator_.reading_count(), 0);
}

TEST_F(MountYawTest, ATruckThatFillsTheViewGivesNoReading) {
  const EgoVelocity ego = DrivingStraight(12.0);
  Scan scan = SeenByTurned(radar_, 0.0, ego, 3);
  for (float& range_rate_mps : scan.range_rate_mps) range_rate_mps = 0.1F;
  EXPECT_FALSE(estimator_.OnScan(stamp_, scan, radar_, ego, workspace_));
}

// It comes nearer by 3 m/s, as what stands still 75 degrees aside does.
TEST_F(MountYawTest, ASlowerTruckAheadIsNoMountThatLooksAside) {
  radar_ = RadarAt("front", 3.5, 0.0, 0.0);
  const EgoVelocity ego = DrivingStraight(12.0);
  const auto found_rad = [&](const MountYawOptions& options) {
    MountYawEstimator estimator(0.5 * kRadPerDeg, options);
    for (unsigned seed = 0; seed < 20; ++seed) {
      Scan scan = SeenByTurned(radar_, 0.0, ego, seed);
      for (std::size_t k = 0; k < 60; ++k) {
        scan.azimuth_rad[k] = 0.001F * (static_cast<float>(k) - 30.0F);
        scan.range_rate_mps[k] = -3.0F;
      }
      stamp_ += std::chrono::milliseconds(200);
      estimator.OnScan(stamp_, scan, radar_, ego, workspace_);
    }
    return std::abs(estimator.error().value);
  };
  EXPECT_LT(found_rad({}), 1.0 * kRadPerDeg);
  EXPECT_GT(found_rad({.min_direction_count = 0}), 1.0) << "few directions would be believed";
}

TEST_F(MountYawTest, AliasedRangeRatesAreUnfolded) {
  radar_.unambiguous_range_rate_mps = 5.0;
  Drive(4.0 * kRadPerDeg, 10);
  EXPECT_NEAR(estimator_.error().value, 4.0 * kRadPerDeg, 0.6 * kRadPerDeg);
}

}  // namespace
}  // namespace dcloc
