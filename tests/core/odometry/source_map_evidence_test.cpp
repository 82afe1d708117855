// What the map says of the sources, by registrations.
#include <gtest/gtest.h>

#include <chrono>
#include <functional>

#include "core/odometry/source_monitor.h"

namespace dcloc {
namespace {

constexpr double kDriven_mps = 10.0;

// A straight drive, scan by scan; wheels and Doppler say as much as `multiple` of the speed.
class StraightDrive {
 public:
  void For(double duration_s, double multiple, double doppler_multiple) {
    for (double t_s = 0.0; t_s < duration_s; t_s += 0.1) {
      stamp_ += std::chrono::milliseconds(100);
      driven_m_ += 0.1 * kDriven_mps;
      OdometryReadings readings;
      readings.wheel_speed = {multiple * kDriven_mps, 0.01};
      readings.yaw_rate = {0.0, 1e-4};
      readings.doppler_speed = {multiple * kDriven_mps, 0.25};
      readings.doppler_direction_count = 12;
      readings.moving_direction_count = 12;
      readings.doppler_radar_count = 1;
      readings.doppler_multiple = doppler_multiple;
      monitor_.OnReadings(stamp_, readings);
      monitor_.OnUsedMotion(0.1 * monitor_.speed().value, 0.0);
    }
  }

  void Register() {
    Pose2 pose;
    pose.translation_m.x() = driven_m_;
    monitor_.OnRegistration(pose, {});
  }

  SourceMonitor& monitor() { return monitor_; }

 private:
  SourceMonitor monitor_;
  Stamp stamp_{std::chrono::seconds(100)};
  double driven_m_ = 0.0;
};

// Doppler is 1.07 times what it was beside the wheels, and the wheels' scale has followed it.
StraightDrive AfterAChange() {
  StraightDrive drive;
  drive.For(5.0, 1.0, 1.0);
  drive.Register();
  drive.monitor().OnDopplersScaleChange(0.0);
  return drive;
}

TEST(SourceMapEvidenceTest, RegistrationsFindThatDopplerHasChanged) {
  StraightDrive drive = AfterAChange();
  int steps = 0;
  while (drive.monitor().IsSound(OdometrySource::kDoppler) && ++steps < 20) {
    drive.For(0.5, 1.07, 1.07);
    drive.Register();
  }
  EXPECT_LT(steps, 8);  // 4 s
  EXPECT_TRUE(drive.monitor().IsSound(OdometrySource::kWheelSpeed));
  EXPECT_NEAR(drive.monitor().speed().value, kDriven_mps, 0.2);
}

TEST(SourceMapEvidenceTest, RegistrationsFindThatTheWheelsHaveChanged) {
  StraightDrive drive = AfterAChange();
  EXPECT_FALSE(drive.monitor().IsCertain(OdometrySource::kDoppler));
  for (int i = 0; i < 60 && !drive.monitor().IsCertain(OdometrySource::kDoppler); ++i) {
    drive.For(0.5, 1.0, 1.07);  // by the scale that Doppler has told
    drive.Register();
    EXPECT_TRUE(drive.monitor().IsSound(OdometrySource::kDoppler)) << i;
  }
  EXPECT_TRUE(drive.monitor().IsCertain(OdometrySource::kDoppler));
}

// Readings that both explain tell nothing.
TEST(SourceMapEvidenceTest, WithoutRegistrationsItStaysOpen) {
  StraightDrive drive = AfterAChange();
  drive.For(20.0, 1.0, 1.07);
  EXPECT_FALSE(drive.monitor().IsCertain(OdometrySource::kDoppler));
  EXPECT_FALSE(drive.monitor().IsRuledOut(OdometrySource::kDoppler));
}

// A gyroscope that is dead, beside a single radar that sees the corner. Registrations lie where the
// motion in use has put the vehicle.
class Corner {
 public:
  explicit Corner(std::chrono::nanoseconds submap_age) : submap_age_(submap_age) {}

  void For(double duration_s, double yaw_rate_radps) {
    for (double t_s = 0.0; t_s < duration_s; t_s += 0.1) {
      stamp_ += std::chrono::milliseconds(100);
      OdometryReadings readings;
      readings.wheel_speed = {kSpeed_mps, 0.01};
      readings.yaw_rate = {0.0, 1e-4};
      readings.doppler_speed = {kSpeed_mps, 0.04};
      readings.single_radar = {.yaw_rate = {yaw_rate_radps, 0.0016},
                               .beyond_gyroscope_radps = yaw_rate_radps};
      readings.doppler_direction_count = 7;
      readings.doppler_radar_count = 1;
      monitor.OnReadings(stamp_, readings);
      Advance(0.1 * monitor.speed().value, 0.1 * monitor.yaw_rate().value);
      monitor.OnRegistration(T_map_vehicle_, {.submap_age = submap_age_});
    }
  }

  SourceMonitor monitor;

 private:
  static constexpr double kSpeed_mps = 4.0;

  void Advance(double forward_m, double turn_rad) {
    T_map_vehicle_ = T_map_vehicle_ * Exp(Tangent<2>(forward_m, 0.0, turn_rad));
    if (const auto unapplied = monitor.OnUsedMotion(forward_m, turn_rad)) {
      T_map_vehicle_ =
          T_map_vehicle_ * Exp(Tangent<2>(unapplied->forward_m, 0.0, unapplied->turn_rad));
    }
  }

  std::chrono::nanoseconds submap_age_;
  Stamp stamp_{std::chrono::seconds(100)};
  Pose2 T_map_vehicle_;
};

TEST(SourceMapEvidenceTest, RegistrationsOfPointsThatAreOldLeaveATurnOpen) {
  Corner at_once(std::chrono::nanoseconds(0));
  Corner lagging(std::chrono::seconds(1));
  for (Corner* corner : {&at_once, &lagging}) {
    corner->For(10.0, 0.0);
    corner->For(0.7, 0.45);
  }
  EXPECT_FALSE(at_once.monitor.Alternative(0));
  EXPECT_TRUE(lagging.monitor.Alternative(0));
}

TEST(SourceMapEvidenceTest, ScansThatFitWhereTheRadarHasTurnedSetTheGyroscopeAside) {
  Corner corner(std::chrono::seconds(1));
  corner.For(10.0, 0.0);
  for (int i = 0; i < 10 && corner.monitor.IsSound(OdometrySource::kYawRate); ++i) {
    corner.For(0.1, 0.45);
    const auto alternative = corner.monitor.Alternative(0);
    if (!alternative) continue;
    const bool turns = alternative->turn_rad > 0.0;
    corner.monitor.OnFits(0, *alternative, turns ? 0.1 : 0.5, turns ? 0.5 : 0.1);
  }
  EXPECT_FALSE(corner.monitor.IsSound(OdometrySource::kYawRate));
  EXPECT_TRUE(corner.monitor.IsSound(OdometrySource::kDoppler));
}

}  // namespace
}  // namespace dcloc
