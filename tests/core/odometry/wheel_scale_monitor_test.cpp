#include "core/odometry/wheel_scale_monitor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/core/options/option_fields_check.h"

namespace dcloc {
namespace {

using std::chrono::milliseconds;

// A vehicle whose speed is that of a town; it reports thirteen times a second.
class SpeedsOfDrive {
 public:
  explicit SpeedsOfDrive(double doppler_factor = 1.0) : doppler_factor_(doppler_factor) {}

  // Drives so long with wheels that report the true speed times `factor`. Gives the changes found.
  std::vector<ScalarEstimate> Drive(double duration_s, double factor) {
    std::vector<ScalarEstimate> changes;
    for (int i = 0; i < static_cast<int>(duration_s / 0.075); ++i, stamp_ += milliseconds(75)) {
      const double speed_mps = 11.0 + 3.0 * std::sin(0.02 * ++reading_);
      const double doppler_mps = doppler_factor_ * speed_mps + 0.03 * normal_(random_);
      const auto change = monitor_.OnSpeeds(stamp_, factor * speed_mps, doppler_mps);
      if (change) changes.push_back(change->share);
    }
    return changes;
  }

  WheelScaleMonitor& monitor() { return monitor_; }

 private:
  WheelScaleMonitor monitor_;
  double doppler_factor_;
  Stamp stamp_{};
  int reading_ = 0;
  std::mt19937 random_{3};
  std::normal_distribution<double> normal_;
};

TEST(WheelScaleMonitorTest, RangeRatesThatAreCorrectedAreNoChange) {
  SpeedsOfDrive drive;
  EXPECT_TRUE(drive.Drive(60.0, 1.0).empty());
  drive.monitor().ForgetRatio();
  EXPECT_TRUE(drive.Drive(60.0, 1.07).empty());
}

TEST(WheelScaleMonitorTest, FindsNothingInWheelsThatAreConstantlyOff) {
  for (const double factor : {1.0, 0.9, 1.2}) {
    SpeedsOfDrive drive;
    EXPECT_TRUE(drive.Drive(600.0, factor).empty()) << factor;
  }
}

TEST(WheelScaleMonitorTest, TellsOnceByWhichFactorWheelsAreSlowerThanDoppler) {
  SpeedsOfDrive drive;
  drive.Drive(2.0, 0.98);
  EXPECT_FALSE(drive.monitor().TakeScale()) << "after two seconds";
  drive.Drive(3.0, 0.98);
  const auto scale = drive.monitor().TakeScale();
  ASSERT_TRUE(scale);
  EXPECT_NEAR(scale->value, 1.0 / 0.98, 0.004);
  EXPECT_GE(std::sqrt(scale->variance), WheelScaleMonitorOptions().speed_sigma_fraction);
  EXPECT_FALSE(drive.monitor().TakeScale()) << "it says the same";
  drive.monitor().TellScaleAgain();
  EXPECT_TRUE(drive.monitor().TakeScale());
}

TEST(WheelScaleMonitorTest, FindsAChangeWithinSecondsAndMeasuresIt) {
  for (const double factor : {0.95, 0.97, 1.03, 1.05}) {
    SpeedsOfDrive drive(1.01);
    ASSERT_TRUE(drive.Drive(20.0, 1.0).empty());
    const auto changes = drive.Drive(4.0, factor);
    ASSERT_EQ(changes.size(), 1U) << factor;
    const double change = 1.0 / factor - 1.0;
    EXPECT_NEAR(changes[0].value, change, 2.0 * std::sqrt(changes[0].variance));
    EXPECT_NEAR(changes[0].value, change, 0.35 * std::abs(change));
  }
}

TEST(WheelScaleMonitorTest, TellsAnUnusualMoment) {
  SpeedsOfDrive drive(1.01);
  EXPECT_FALSE(drive.monitor().IsUnusual(20.0, 25.0, 0.0)) << "what is usual is not known";
  drive.Drive(20.0, 1.0);
  EXPECT_FALSE(drive.monitor().IsUnusual(20.0, 20.2, 0.0));
  EXPECT_FALSE(drive.monitor().IsUnusual(20.0, 20.5, 0.0)) << "noise";
  EXPECT_TRUE(drive.monitor().IsUnusual(20.0, 21.2, 0.0));
  EXPECT_TRUE(drive.monitor().IsUnusual(20.0, 19.2, 0.0));
  EXPECT_FALSE(drive.monitor().IsUnusual(20.0, 21.2, 4.0)) << "one of the two may be late";
}

TEST(WheelScaleMonitorTest, FindsThatTheChangeEnds) {
  SpeedsOfDrive drive;
  drive.Drive(20.0, 1.0);
  const auto begun = drive.Drive(10.0, 1.05);
  const auto ended = drive.Drive(10.0, 1.0);
  double factor = 1.0;
  for (const ScalarEstimate& change : begun) factor *= 1.0 + change.value;
  EXPECT_NEAR(factor, 1.0 / 1.05, 0.012);
  for (const ScalarEstimate& change : ended) factor *= 1.0 + change.value;
  EXPECT_NEAR(factor, 1.0, 0.012);
}

TEST(WheelScaleMonitorTest, FollowsAChangeThatComesSlowly) {
  SpeedsOfDrive drive;
  drive.Drive(20.0, 1.0);
  double factor = 1.0;
  for (int second = 1; second <= 20; ++second) {
    for (const ScalarEstimate& change : drive.Drive(1.0, 1.0 + 0.0025 * second)) {
      factor *= 1.0 + change.value;
    }
  }
  EXPECT_NEAR(factor, 1.0 / 1.05, 0.02);
}

TEST(WheelScaleMonitorTest, SlipIsNoScale) {
  for (const double factor : {0.0, 0.5, 1.5}) {
    SpeedsOfDrive drive;
    drive.Drive(20.0, 1.0);
    EXPECT_TRUE(drive.Drive(1.0, factor).empty()) << factor;
    EXPECT_TRUE(drive.Drive(20.0, 1.0).empty()) << factor;
  }
}

TEST(WheelScaleMonitorTest, WhatWasNotSoundDoesNotCount) {
  SpeedsOfDrive drive;
  drive.Drive(20.0, 1.0);
  for (int i = 0; i < 10; ++i) {
    EXPECT_TRUE(drive.Drive(0.7, 1.05).empty());
    drive.monitor().OnUnsound();
  }
}

TEST(WheelScaleMonitorTest, EachFieldIsBounded) {
  ExpectEachFieldIsBounded<WheelScaleMonitorOptions>();
}

}  // namespace
}  // namespace dcloc
