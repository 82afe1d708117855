#include "core/odometry/held_velocity.h"

#include <gtest/gtest.h>

namespace dcloc {
namespace {

using std::chrono::milliseconds;

EgoVelocity Moving(double speed_mps, double yaw_rate_radps) {
  return {.linear_mps = {speed_mps, 0.0, 0.0}, .angular_radps = {0.0, 0.0, yaw_rate_radps}};
}

class HeldVelocityTest : public ::testing::Test {
 protected:
  // So many times, 75 ms apart; the age of the last one, which is contradicted.
  std::chrono::nanoseconds Report(const EgoVelocity& velocity, int count = 1) {
    for (int i = 0; i < count; ++i) held_.OnReported(stamp_ += milliseconds(75), velocity);
    held_.OnContradicted();
    return held_.age();
  }

  EgoVelocity Now() const { return Moving(value_mps_, 0.1); }

  HeldVelocity held_;
  double value_mps_ = 12.0;
  Stamp stamp_{std::chrono::seconds(100)};
};

TEST_F(HeldVelocityTest, WhatIsRepeatedIsAsOldAsWhenItFirstCame) {
  EXPECT_EQ(Report(Moving(12.0, 0.1), 10), milliseconds(675));
  EXPECT_EQ(Report(Moving(12.0, 0.1)), milliseconds(750)) << "it stays contradicted";
  EXPECT_EQ(Report(Moving(12.01, 0.1)), milliseconds(0));
  EXPECT_EQ(Report(Moving(12.01, 0.11)), milliseconds(0));
}

TEST_F(HeldVelocityTest, WhatNothingContradictsIsTrueAsLongAsItLasts) {
  for (int i = 0; i < 100; ++i) held_.OnReported(stamp_ += milliseconds(75), Moving(12.0, 0.1));
  EXPECT_EQ(held_.age(), milliseconds(0));
}

TEST_F(HeldVelocityTest, ForHowLongAnOldVelocityWasTrustedIsSaidOnce) {
  EXPECT_EQ(held_.TakeTrusted(), milliseconds(0));
  Report(Moving(12.0, 0.1), 10);
  held_.OnContradicted();
  EXPECT_EQ(held_.TakeTrusted(), milliseconds(675));
  Report(Moving(12.0, 0.1));
  EXPECT_EQ(held_.TakeTrusted(), milliseconds(0)) << "it was not trusted any more";
}

TEST_F(HeldVelocityTest, AVelocityThatIsRepeatedForLongerThanAnyBeforeIsUnusual) {
  const auto change = [this](int count, int repeats) {
    for (int i = 0; i < count; ++i) {
      value_mps_ += 0.01;
      for (int k = 0; k <= repeats; ++k) held_.OnReported(stamp_ += milliseconds(75), Now());
    }
  };
  change(30, 10);
  EXPECT_FALSE(held_.IsUnusual()) << "not known yet";
  held_ = {};
  change(60, 1);
  EXPECT_FALSE(held_.IsUnusual());
  change(1, 4);
  EXPECT_FALSE(held_.IsUnusual());
  held_.OnReported(stamp_ += milliseconds(75), Now());
  EXPECT_TRUE(held_.IsUnusual());
}

TEST_F(HeldVelocityTest, ASteadySpeedStraightAheadIsNoChange) {
  for (int i = 0; i < 100; ++i) held_.OnReported(stamp_ += milliseconds(75), Moving(12.0, 0.0));
  for (int i = 0; i < 30; ++i) held_.OnReported(stamp_ += milliseconds(75), Moving(12.0, 0.1));
  EXPECT_FALSE(held_.IsUnusual()) << "a constant curve, as simulated";
}

TEST_F(HeldVelocityTest, AVehicleThatStandsOrDrivesStraightAheadIsNotHeld) {
  EXPECT_EQ(Report(Moving(0.0, 0.01), 10), milliseconds(0));
  EXPECT_EQ(Report(Moving(12.0, 0.0), 10), milliseconds(0));
}

}  // namespace
}  // namespace dcloc
