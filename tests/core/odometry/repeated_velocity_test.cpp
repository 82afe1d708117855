#include "core/odometry/repeated_velocity.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

namespace dcloc {
namespace {

class RepeatedVelocityTest : public ::testing::Test {
 protected:
  // Velocities that differ from one to the next.
  void GiveChanging(int count) {
    for (int i = 0; i < count; ++i) Give(10.0 + 1e-9 * ++changes_);
  }
  // `count` times the same; what they say in sum.
  double GiveSame(double speed_mps, int count) {
    double sum = 0.0;
    for (int i = 0; i < count; ++i) sum += Give(speed_mps);
    return sum;
  }
  double Give(std::optional<double> speed_mps, double yaw_rate_radps = 0.01) {
    repeated_.OnVelocity(speed_mps ? std::optional(ReportedVelocity{*speed_mps, yaw_rate_radps})
                                   : std::nullopt);
    return repeated_.log_failed();
  }

  RepeatedVelocity repeated_;
  int changes_ = 0;
};

TEST_F(RepeatedVelocityTest, VelocitiesThatChangeSayNothing) {
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(Give(10.0 + 1e-9 * i), 0.0);
}

TEST_F(RepeatedVelocityTest, AFewThatAreTheSameSayMuch) {
  GiveChanging(300);
  EXPECT_GT(GiveSame(12.5, 4), 8.0);
}

// What a frozen source does is not what it usually does.
TEST_F(RepeatedVelocityTest, ASourceThatFreezesOnceMoreIsFoundAsSoon) {
  GiveChanging(300);
  GiveSame(12.5, 1000);
  EXPECT_TRUE(repeated_.is_frozen());
  GiveChanging(30);
  EXPECT_FALSE(repeated_.is_frozen());
  EXPECT_GT(GiveSame(14.5, 5), 7.0);
}

// A source that has changed was not frozen.
TEST_F(RepeatedVelocityTest, WhatARunHasSaidIsTakenBackWhenItEnds) {
  GiveChanging(300);
  const double said = GiveSame(12.5, 4);
  EXPECT_DOUBLE_EQ(Give(12.6), -said);
  EXPECT_EQ(Give(12.7), 0.0);
}

TEST_F(RepeatedVelocityTest, AVehicleThatStandsSaysZeroForGoodReason) {
  GiveChanging(300);
  EXPECT_EQ(GiveSame(0.0, 1000), 0.0);
}

// Wheels may be coarse, and a gyroscope that works is not at once.
TEST_F(RepeatedVelocityTest, OneOfTheTwoThatRepeatsItselfSaysNothing) {
  GiveChanging(300);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(Give(12.5, 0.01 + 1e-9 * i), 0.0);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(Give(12.5, 0.0), 0.0) << "straight ahead";
}

// Speeds in whole kilometres an hour, or three scans for each message of the bus.
TEST_F(RepeatedVelocityTest, WhatOftenRepeatsItselfSaysNothingByIt) {
  double most = 0.0;
  for (int i = 0; i < 300; ++i) {
    const double said = GiveSame(10.0 + i, 3);
    if (i > 20) most = std::max(most, said);
  }
  EXPECT_LT(most, 0.1);
}

// A coarse speed goes through values at which it stays for a while.
TEST_F(RepeatedVelocityTest, RunsOfCoarseVelocitiesSayLittle) {
  double most = 0.0;
  for (int i = 0; i < 100; ++i) {
    GiveChanging(30);
    most = std::max(i > 20 ? most : 0.0, GiveSame(20.0 + i, 2 + i % 4));
  }
  EXPECT_LT(most, 5.0);
}

TEST_F(RepeatedVelocityTest, SilenceSaysNothing) {
  GiveChanging(300);
  EXPECT_EQ(Give(std::nullopt), 0.0);
  EXPECT_GT(GiveSame(10.0 + 1e-9 * changes_, 2), 3.0) << "the one before it counts";
}

}  // namespace
}  // namespace dcloc
