#include "client/datasets/check/velocity_check.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <functional>

#include "core/geometry/covariance.h"

namespace dcloc {
namespace {

double Speed(double time_s) { return 10.0 + 3.0 * std::sin(0.6 * time_s); }
double YawRate(double time_s) { return 0.2 * std::cos(0.4 * time_s); }

/// Twenty seconds at 20 scans a second; velocities are what `report` makes of the moment [s].
Drive DriveThat(const std::function<std::optional<EgoVelocity>(double)>& report) {
  Drive drive;
  Pose3 T_map_vehicle;
  constexpr double kInterval_s = 0.05;
  for (int i = 0; i < 400; ++i) {
    const double time_s = kInterval_s * i;
    DriveScan& entry = drive.scans.emplace_back();
    entry.scan.stamp = Stamp(std::chrono::seconds(1000) +
                             std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 * time_s)));
    entry.scan.ego_velocity = report(time_s);
    entry.T_map_vehicle = T_map_vehicle;
    Vector6d step = Vector6d::Zero();
    step(0) = kInterval_s * Speed(time_s + 0.5 * kInterval_s);
    step(5) = kInterval_s * YawRate(time_s + 0.5 * kInterval_s);
    T_map_vehicle = T_map_vehicle * Exp(step);
  }
  return drive;
}

EgoVelocity Reported(double time_s, double speed_factor = 1.0, double yaw_rate_factor = 1.0) {
  return {{speed_factor * Speed(time_s), 0.0, 0.0},
          {0.0, 0.0, yaw_rate_factor * YawRate(time_s)},
          std::nullopt};
}

TEST(VelocityCheckTest, WhatIsRightIsOneTimesTheTruthAndNotLate) {
  const VelocityCheck check = CheckVelocities(DriveThat([](double s) { return Reported(s); }));
  EXPECT_EQ(check.scan_count, 400U);
  EXPECT_EQ(check.velocity_count, 400U);
  EXPECT_NEAR(check.speed_factor.value(), 1.0, 0.01);
  EXPECT_NEAR(check.yaw_rate_factor.value(), 1.0, 0.01);
  EXPECT_FALSE(check.delay_s.has_value());
}

TEST(VelocityCheckTest, UnitsAndSignsAreFactors) {
  const VelocityCheck check =
      CheckVelocities(DriveThat([](double s) { return Reported(s, 3.6, -1.0); }));
  EXPECT_NEAR(check.speed_factor.value(), 3.6, 0.03);
  EXPECT_NEAR(check.yaw_rate_factor.value(), -1.0, 0.01);
  const VelocityCheck silent =
      CheckVelocities(DriveThat([](double s) { return Reported(s, 0.0, 1.0); }));
  EXPECT_NEAR(silent.speed_factor.value(), 0.0, 1e-9);
}

TEST(VelocityCheckTest, ADelayIsFoundWhicheverItsUnits) {
  for (const double delay_s : {0.3, -0.2}) {
    const VelocityCheck check =
        CheckVelocities(DriveThat([&](double s) { return Reported(s - delay_s, 3.6); }));
    EXPECT_NEAR(check.delay_s.value(), delay_s, 0.021);
  }
}

TEST(VelocityCheckTest, WithoutReferencePosesTheyAreCountedAlone) {
  Drive drive =
      DriveThat([](double s) { return s < 5.0 ? std::optional(Reported(s)) : std::nullopt; });
  drive.pose_source = PoseSource::kOdometry;
  const VelocityCheck check = CheckVelocities(drive);
  EXPECT_EQ(check.velocity_count, 100U);
  EXPECT_FALSE(check.speed_factor || check.yaw_rate_factor || check.delay_s);
  drive.velocity_source = VelocitySource::kDoppler;
  EXPECT_EQ(CheckVelocities(drive).velocity_count, 0U);
  EXPECT_EQ(CheckVelocities(Drive()).scan_count, 0U);
}

TEST(VelocityCheckTest, AStraightDriveDoesNotTellYawRates) {
  Drive drive = DriveThat([](double s) { return Reported(s); });
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    drive.scans[i].T_map_vehicle =
        Pose3{{0.5 * static_cast<double>(i), 0.0, 0.0}, Eigen::Quaterniond::Identity()};
  }
  EXPECT_FALSE(CheckVelocities(drive).yaw_rate_factor.has_value());
}

}  // namespace
}  // namespace dcloc
