#include "core/odometry/source_monitor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dcloc {
namespace {

using std::chrono::milliseconds;

constexpr int kScan_ms = 77;

ScalarEstimate Speed(double mps, double sigma_mps) { return {mps, sigma_mps * sigma_mps}; }

// A vehicle at 15 m/s that speeds up and slows down and swerves, and what its sources say.
class Vehicle {
 public:
  using Lie = std::function<void(OdometryReadings& readings)>;

  // Goes on for `duration_s`, the sources spoilt by `lie`.
  void Drive(
      double duration_s, const Lie& lie = [](OdometryReadings&) {}) {
    for (const double end_s = now_s_ + duration_s; now_s_ < end_s; now_s_ += 1e-3 * scan_ms) {
      const double speed_mps = SpeedAt(now_s_);
      const double yaw_rate_radps = YawRateAt(now_s_);
      OdometryReadings readings{.wheel_speed = Speed(speed_mps, 0.1),
                                .yaw_rate = Speed(yaw_rate_radps, 0.005),
                                .doppler_speed = Speed(speed_mps, 0.5),
                                .doppler_yaw_rate = Speed(yaw_rate_radps, 0.03),
                                .doppler_direction_count = 12};
      lie(readings);
      stamp_ += milliseconds(scan_ms);
      monitor.OnReadings(stamp_, readings);
      const Eigen::Vector3d moved = Moved(1e-3 * scan_ms);
      const auto correction = monitor.OnUsedMotion(
          used(readings.wheel_speed, speed_mps) / speed_mps * moved.x(), moved.z());
      if (correction) corrected_m += correction->forward_m;
      T_map_vehicle_ = T_map_vehicle_ * Exp(moved);
      if (is_registered) monitor.OnRegistration(T_map_vehicle_, {});
      if (!found_wrong_after_s && monitor.sound() != OdometrySources(7)) {
        found_wrong_after_s = now_s_;
      }
    }
  }

  SourceMonitor monitor;
  bool is_registered = false;
  int scan_ms = kScan_ms;
  double turn_radps = 0.15;                   // at most
  std::optional<double> found_wrong_after_s;  // since the drive's beginning
  double corrected_m = 0.0;

 private:
  double SpeedAt(double time_s) const { return 15.0 + 3.0 * std::sin(0.4 * time_s); }
  double YawRateAt(double time_s) const { return turn_radps * std::sin(0.7 * time_s); }

  // Way and turn of the last `step_s`.
  Eigen::Vector3d Moved(double step_s) const {
    constexpr int kParts = 10;
    const double part_s = step_s / kParts;
    Eigen::Vector3d moved = Eigen::Vector3d::Zero();
    for (int i = 0; i < kParts; ++i) {
      const double time_s = now_s_ - (i + 0.5) * part_s;
      moved += part_s * Eigen::Vector3d(SpeedAt(time_s), 0.0, YawRateAt(time_s));
    }
    return moved;
  }

  static double used(const std::optional<ScalarEstimate>& wheels, double otherwise) {
    return wheels ? wheels->value : otherwise;
  }

  double now_s_ = 0.0;
  Stamp stamp_{std::chrono::seconds(1'700'000'000)};
  Pose2 T_map_vehicle_;
};

TEST(SourceMonitorTest, SourcesThatAgreeAreSound) {
  Vehicle vehicle;
  vehicle.Drive(60.0);
  EXPECT_EQ(vehicle.monitor.sound(), OdometrySources(7));
  EXPECT_FALSE(vehicle.found_wrong_after_s);
  EXPECT_GT(vehicle.monitor.confidence(), 0.9);
}

// In curves, and with a single radar, whose yaw rate does not hold against the gyroscope's.
TEST(SourceMonitorTest, RareScansMakeNoSourceFail) {
  for (const int scan_ms : {250, 530}) {
    Vehicle vehicle;
    vehicle.is_registered = true;
    vehicle.scan_ms = scan_ms;
    const auto without_turn = [](OdometryReadings& r) { r.doppler_yaw_rate.reset(); };
    vehicle.turn_radps = 0.6;
    vehicle.Drive(60.0, without_turn);
    EXPECT_FALSE(vehicle.found_wrong_after_s) << scan_ms;
    EXPECT_EQ(vehicle.monitor.sound(), OdometrySources(7)) << scan_ms;
  }
}

struct Case {
  const char* name;
  OdometrySource source;
  Vehicle::Lie lie;
};

const Case kCases[] = {
    {"WheelsStand", OdometrySource::kWheelSpeed,
     [](OdometryReadings& r) { r.wheel_speed->value = 0.0; }},
    {"WheelsUnsigned", OdometrySource::kWheelSpeed,
     [](OdometryReadings& r) { r.wheel_speed->value *= -1.0; }},
    {"WheelsTooFast", OdometrySource::kWheelSpeed,
     [](OdometryReadings& r) { r.wheel_speed->value *= 1.3; }},
    {"WheelsTooSlowAndSureOfIt", OdometrySource::kWheelSpeed,
     [](OdometryReadings& r) { *r.wheel_speed = Speed(0.6 * r.wheel_speed->value, 1e-6); }},
    {"GyroTurns", OdometrySource::kYawRate, [](OdometryReadings& r) { r.yaw_rate->value += 0.2; }},
    {"AMoverFillsTheView", OdometrySource::kDoppler,
     [](OdometryReadings& r) {
       r.doppler_speed = Speed(4.0, 0.5);
       r.doppler_direction_count = 4;
     }},
};

class FailingSourceTest : public ::testing::TestWithParam<Case> {};

TEST_P(FailingSourceTest, IsFoundWithinHalfASecondAndTakenBack) {
  Vehicle vehicle;
  vehicle.is_registered = true;
  vehicle.Drive(10.0);
  ASSERT_EQ(vehicle.monitor.sound(), OdometrySources(7));
  vehicle.Drive(5.0, GetParam().lie);
  ASSERT_TRUE(vehicle.found_wrong_after_s);
  EXPECT_LT(*vehicle.found_wrong_after_s, 10.6);
  OdometrySources others(7);
  others.reset(static_cast<std::size_t>(GetParam().source));
  EXPECT_EQ(vehicle.monitor.sound(), others);
  vehicle.Drive(6.0);
  EXPECT_EQ(vehicle.monitor.sound(), OdometrySources(7)) << "it agrees again";
}

INSTANTIATE_TEST_SUITE_P(Cases, FailingSourceTest, ::testing::ValuesIn(kCases),
                         [](const auto& test) { return std::string(test.param.name); });

// Both explain all that is said. With registrations the mover would never win.
TEST(SourceMonitorTest, WhereNothingIsRegisteredOthersAreTried) {
  const auto mover = [](OdometryReadings& r) {
    r.doppler_speed = Speed(4.0, 0.5);
    r.doppler_direction_count = 4;
  };
  Vehicle vehicle;
  vehicle.Drive(10.0);
  vehicle.Drive(3.0, mover);
  ASSERT_FALSE(vehicle.monitor.IsSound(OdometrySource::kDoppler));
  ASSERT_NEAR(vehicle.corrected_m, 0.0, 2.0);
  vehicle.Drive(2.0, mover);
  EXPECT_TRUE(vehicle.monitor.IsSound(OdometrySource::kDoppler));
  EXPECT_FALSE(vehicle.monitor.IsSound(OdometrySource::kWheelSpeed));
  const double at_12_instead_of_4_mps_m = 3.5 * (12.0 - 4.0);
  EXPECT_NEAR(vehicle.corrected_m, -at_12_instead_of_4_mps_m, 3.0) << "all along";
}

// A gyro that is off by less than Doppler can tell.
TEST(SourceMonitorTest, RegistrationsShowWhatTheSourcesCannot) {
  Vehicle vehicle;
  vehicle.is_registered = true;
  vehicle.Drive(10.0);
  ASSERT_EQ(vehicle.monitor.sound(), OdometrySources(7));
  vehicle.Drive(6.0, [](OdometryReadings& r) { r.yaw_rate->value += 0.05; });
  EXPECT_FALSE(vehicle.monitor.IsSound(OdometrySource::kYawRate));
  EXPECT_TRUE(vehicle.monitor.IsSound(OdometrySource::kWheelSpeed));
}

TEST(SourceMonitorTest, SpeedAndYawRateAreThoseOfTheSoundSources) {
  Vehicle vehicle;
  vehicle.Drive(10.0);
  vehicle.Drive(3.0, [](OdometryReadings& r) { r.wheel_speed->value = 0.0; });
  EXPECT_GT(vehicle.monitor.speed().value, 10.0);
  EXPECT_LT(vehicle.monitor.speed().variance, 1.0);
}

TEST(SourceMonitorTest, SilentSourcesAreNotTakenForWrong) {
  Vehicle vehicle;
  vehicle.Drive(10.0, [](OdometryReadings& r) {
    r.wheel_speed.reset();
    r.yaw_rate.reset();
  });
  EXPECT_TRUE(vehicle.monitor.IsSound(OdometrySource::kDoppler));
  vehicle.Drive(10.0);
  EXPECT_EQ(vehicle.monitor.sound(), OdometrySources(7));
}

TEST(SourceMonitorTest, AGyroscopeThatRepeatsItselfIsNotTakenBackOnAStraightRoad) {
  Vehicle vehicle;
  vehicle.is_registered = true;
  vehicle.Drive(10.0);
  const auto dead = [](OdometryReadings& readings) {
    readings.yaw_rate->value = 0.0;
    readings.yaw_rate_is_repeated = true;
  };
  vehicle.Drive(10.0, dead);
  EXPECT_FALSE(vehicle.monitor.IsSound(OdometrySource::kYawRate));
  vehicle.turn_radps = 0.0;
  vehicle.Drive(60.0, dead);
  EXPECT_FALSE(vehicle.monitor.IsSound(OdometrySource::kYawRate));
  vehicle.Drive(10.0);
  EXPECT_TRUE(vehicle.monitor.IsSound(OdometrySource::kYawRate));
}

/// A straight drive whose wheels creep away from the truth, so that it takes a while to find them
/// wrong.
struct CreepingWheels {
  bool are_found = false;
  double used_m = 0.0;
  double true_m = 0.0;
  double corrected_m = 0.0;
};

// Accepted registrations lie where the motion that was used has put the vehicle.
CreepingWheels DriveOnCreepingWheels(std::optional<RegistrationEvidence> registrations) {
  SourceMonitor monitor;
  CreepingWheels drive;
  Stamp stamp{std::chrono::seconds(1'700'000'000)};
  for (int i = 0; i < 130; ++i) {
    stamp += milliseconds(kScan_ms);
    const double off_mps = i < 60 ? 0.0 : 0.1 * (i - 60);
    monitor.OnReadings(stamp, {.wheel_speed = Speed(15.0 + off_mps, 0.1),
                               .yaw_rate = Speed(0.0, 0.005),
                               .doppler_speed = Speed(15.0, 0.3),
                               .doppler_yaw_rate = Speed(0.0, 0.03),
                               .doppler_direction_count = 12});
    const double step_s = i == 0 ? 0.0 : 1e-3 * kScan_ms;
    const double step_m = monitor.speed().value * step_s;
    drive.used_m += step_m;
    drive.true_m += 15.0 * step_s;
    if (const auto unapplied = monitor.OnUsedMotion(step_m, 0.0)) {
      drive.corrected_m += unapplied->forward_m;
    }
    if (registrations) {
      monitor.OnRegistration(Pose2{{drive.used_m + drive.corrected_m, 0.0}, 0.0}, *registrations);
    }
  }
  drive.are_found = !monitor.IsSound(OdometrySource::kWheelSpeed);
  return drive;
}

TEST(SourceMonitorTest, WhatWasNotAppliedIsCorrected) {
  const CreepingWheels drive = DriveOnCreepingWheels(std::nullopt);
  EXPECT_TRUE(drive.are_found);
  EXPECT_LT(std::abs(drive.used_m + drive.corrected_m - drive.true_m),
            std::abs(drive.used_m - drive.true_m));
}

TEST(SourceMonitorTest, RegistrationsThatDoNotSeeTheWayLeaveItToBeCorrected) {
  const CreepingWheels unseen =
      DriveOnCreepingWheels(RegistrationEvidence{.observes_along_track = false});
  EXPECT_TRUE(unseen.are_found);
  EXPECT_LT(unseen.corrected_m, -0.1);
  const CreepingWheels seen = DriveOnCreepingWheels(RegistrationEvidence{});
  EXPECT_GT(seen.corrected_m, 0.3 * unseen.corrected_m) << "what a registration saw is corrected";
}

// What is sound by the first radar, whose range rates are too small, and then by it and four
// others.
OdometrySources SoundAfterOthersJoin(std::size_t joined_radar_count) {
  SourceMonitor monitor;
  Stamp stamp{std::chrono::seconds(1'700'000'000)};
  OdometryReadings readings{.wheel_speed = Speed(12.3, 0.1),
                            .yaw_rate = Speed(0.0, 0.005),
                            .doppler_speed = Speed(7.4, 0.05),
                            .doppler_direction_count = 11,
                            .doppler_radar_count = 1};
  monitor.OnReadings(stamp, readings);
  readings.doppler_speed = Speed(12.25, 0.05);
  readings.alternative_speed = Speed(7.4, 0.05);
  readings.doppler_direction_count = 24;
  readings.doppler_radar_count = joined_radar_count;
  for (int i = 0; i < 10; ++i) monitor.OnReadings(stamp += std::chrono::milliseconds(75), readings);
  return monitor.sound();
}

TEST(SourceMonitorTest, RadarsThatJoinOutweighTheFirst) {
  EXPECT_EQ(SoundAfterOthersJoin(5), OdometrySources(7));
  EXPECT_NE(SoundAfterOthersJoin(1), OdometrySources(7)) << "a single radar has changed its mind";
}

OdometrySources SoundBySpeeds(double wheels_mps, double doppler_mps) {
  SourceMonitor monitor;
  Stamp stamp{std::chrono::seconds(1'700'000'000)};
  for (int i = 0; i < 10; ++i) {
    monitor.OnReadings(stamp += std::chrono::milliseconds(75),
                       {.wheel_speed = Speed(wheels_mps, 0.1),
                        .yaw_rate = Speed(0.0, 0.005),
                        .doppler_speed = Speed(doppler_mps, 0.05),
                        .doppler_direction_count = 11,
                        .doppler_radar_count = 1});
  }
  return monitor.sound();
}

TEST(SourceMonitorTest, AVehicleHardlyDrivesBackwardsFast) {
  EXPECT_FALSE(Contains(SoundBySpeeds(12.0, -12.0), OdometrySource::kDoppler));
  EXPECT_FALSE(Contains(SoundBySpeeds(-12.0, 12.0), OdometrySource::kWheelSpeed));
  EXPECT_EQ(SoundBySpeeds(-12.0, -12.0), OdometrySources(7)) << "unless all say so";
}

TEST(SourceMonitorTest, InputsThatMeanNothingGiveNumbers) {
  SourceMonitor monitor;
  Stamp stamp{std::chrono::seconds(1'700'000'000)};
  for (int i = 0; i < 1000; ++i) {
    const double absurd = i % 2 == 0 ? 150.0 : -150.0;
    if (i % 3 != 0) stamp += std::chrono::microseconds(100 * i);
    monitor.OnReadings(stamp, {.wheel_speed = ScalarEstimate{absurd, i % 5 == 0 ? 1e12 : 0.0},
                               .yaw_rate = ScalarEstimate{-absurd / 15.0, 0.0},
                               .doppler_speed = ScalarEstimate{-absurd, 1e-12},
                               .doppler_yaw_rate = ScalarEstimate{absurd / 15.0, 1e12}});
    monitor.OnUsedMotion(absurd, absurd);
    monitor.OnRegistration(Pose2{{absurd * i, 0.0}, absurd},
                           {.is_accepted = i % 2 == 0, .observes_along_track = i % 3 == 0});
    ASSERT_TRUE(std::isfinite(monitor.speed().value) && std::isfinite(monitor.speed().variance));
    ASSERT_TRUE(std::isfinite(monitor.yaw_rate().value) && std::isfinite(monitor.confidence()));
  }
}

// A bus that is dead while the vehicle pulls away, or a queue beside a vehicle that stands.
double SpeedOfWhoPullsAway(int standing_direction_count) {
  SourceMonitor monitor;
  Stamp stamp{};
  for (int i = 0; i < 150; ++i) {
    const double doppler_mps = std::max(0.0, 2.0 * 0.077 * (i - 110));
    const bool moves = doppler_mps > 0.5;
    monitor.OnReadings(stamp += milliseconds(77),
                       {.wheel_speed = Speed(0.0, 0.1),
                        .yaw_rate = Speed(0.0, 0.005),
                        .doppler_speed = Speed(doppler_mps, 0.5),
                        .doppler_direction_count = 8,
                        .moving_direction_count = moves ? 8 : 0,
                        .standing_direction_count = moves ? standing_direction_count : 0});
    static_cast<void>(monitor.OnUsedMotion(0.077 * monitor.speed().value, 0.0));
  }
  return monitor.speed().value;
}

TEST(SourceMonitorTest, WhoStandsSeesSomethingThatStandsStill) {
  EXPECT_NEAR(SpeedOfWhoPullsAway(0), 2.0 * 0.077 * 39, 0.5);
  EXPECT_NEAR(SpeedOfWhoPullsAway(4), 0.0, 0.5) << "the queue beside it pulls away";
}

// On a straight road compensated range rates agree with the gyroscope, of many radars well.
TEST(SourceMonitorTest, RangeRatesOfZeroAgreeWithNothing) {
  Vehicle vehicle;
  vehicle.turn_radps = 0.0;
  vehicle.Drive(3.0, [](OdometryReadings& readings) {
    readings.doppler_speed = Speed(0.0, 0.02);
    readings.doppler_yaw_rate = Speed(0.0, 0.005);
    readings.doppler_direction_count = 30;
    readings.doppler_radar_count = 5;
  });
  EXPECT_TRUE(vehicle.monitor.IsSound(OdometrySource::kWheelSpeed));
  EXPECT_FALSE(vehicle.monitor.IsSound(OdometrySource::kDoppler));
}

TEST(SourceMonitorTest, ASingleRadarAndRegistrationsFindADeadGyroscope) {
  const auto alone = [](OdometryReadings& readings) {
    readings.single_radar = {.yaw_rate = *std::exchange(readings.doppler_yaw_rate, std::nullopt)};
  };
  Vehicle vehicle;
  vehicle.turn_radps = 0.4;
  vehicle.is_registered = true;
  vehicle.Drive(10.0, alone);
  EXPECT_FALSE(vehicle.found_wrong_after_s.has_value());
  vehicle.Drive(1.5, [&](OdometryReadings& readings) {
    alone(readings);
    readings.yaw_rate->value = 0.0;
    readings.single_radar->beyond_gyroscope_radps =
        std::max(0.0, std::abs(readings.single_radar->yaw_rate.value) - 0.1);
  });
  EXPECT_FALSE(vehicle.monitor.IsSound(OdometrySource::kYawRate));
  EXPECT_TRUE(vehicle.monitor.IsSound(OdometrySource::kDoppler));
  EXPECT_TRUE(vehicle.monitor.IsSound(OdometrySource::kWheelSpeed));
}

}  // namespace
}  // namespace dcloc
