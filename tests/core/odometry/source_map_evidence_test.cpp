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

}  // namespace
}  // namespace dcloc
