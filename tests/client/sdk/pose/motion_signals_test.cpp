#include "client/sdk/pose/motion_signals.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "tests/client/sdk/pose/answers.h"

namespace dcloc::client {
namespace {

using ::testing::HasSubstr;

TEST(MotionSignalsTest, WheelsAndGyroscopeEachTickAtTheirOwnRate) {
  MotionSignals signals;
  for (int i = 0; i <= 2; ++i) {
    ASSERT_TRUE(signals.Add({.stamp_ns = At(20 * i), .speed_mps = 10.0 + i}).ok());
  }
  EXPECT_FALSE(signals.VelocityAt(At(10)).has_value()) << "the yaw rate is not known";
  for (int i = 0; i <= 8; ++i) {
    ASSERT_TRUE(signals.Add({.stamp_ns = At(5 * i), .yaw_rate_radps = 0.01 * i}).ok());
  }
  const auto between = signals.VelocityAt(At(30));
  ASSERT_TRUE(between.has_value());
  EXPECT_DOUBLE_EQ(between->linear_mps().x(), 11.5);
  EXPECT_DOUBLE_EQ(between->angular_radps().z(), 0.06);
  EXPECT_EQ(between->covariance_size(), 0);
  EXPECT_EQ(signals.VelocityAt(At(20))->linear_mps().x(), 11.0) << "a tick is given as it is";
}

TEST(MotionSignalsTest, TicksAroundAScanAreThoseOfBothSignals) {
  MotionSignals signals;
  for (int i = 0; i <= 5; ++i) {
    ASSERT_TRUE(signals.Add({.stamp_ns = At(20 * i), .speed_mps = 10.0 + i}).ok());
  }
  for (int i = 0; i <= 2; ++i) {
    ASSERT_TRUE(signals.Add({.stamp_ns = At(50 * i), .yaw_rate_radps = 0.1 * i}).ok());
  }
  const v1::MotionTicks ticks = signals.TicksAround(At(30), At(70));
  ASSERT_EQ(ticks.stamp_offset_ns_size(), 7);  // 0, 20, 40, 50, 60, 80, 100
  EXPECT_EQ(ticks.stamp_offset_ns(0), -70 * kMillisecond_ns);
  EXPECT_EQ(ticks.stamp_offset_ns(3), -20 * kMillisecond_ns);
  EXPECT_FLOAT_EQ(ticks.speed_mps(3), 12.5F);
  EXPECT_FLOAT_EQ(ticks.yaw_rate_radps(2), 0.08F);
  EXPECT_EQ(MotionSignals().TicksAround(At(0), At(10)).stamp_offset_ns_size(), 0);
}

TEST(MotionSignalsTest, TicksOfAFastBusAreThinnedAndOfALongTimeNotSent) {
  MotionSignals signals;
  for (int ms = 0; ms <= 2000; ++ms) {
    ASSERT_TRUE(signals.Add({At(ms), 10.0, 0.1}).ok());
  }
  const v1::MotionTicks ticks = signals.TicksAround(At(1000), At(2000));
  EXPECT_GT(ticks.stamp_offset_ns_size(), 100);
  EXPECT_LE(ticks.stamp_offset_ns_size(), 202);
  EXPECT_EQ(ticks.stamp_offset_ns(0), -1000 * kMillisecond_ns);
  EXPECT_EQ(ticks.stamp_offset_ns(ticks.stamp_offset_ns_size() - 1), 0);
  EXPECT_EQ(signals.TicksAround(At(999), At(2000)).stamp_offset_ns_size(), 0);
}

// One that came long ago is no part of it: the server refuses what is far from the scan.
TEST(MotionSignalsTest, TicksFarFromTheScanDoNotGoWithIt) {
  MotionSignals signals;
  ASSERT_TRUE(signals.Add({At(0), 10.0, 0.1}).ok());
  ASSERT_TRUE(signals.Add({At(5000), 10.0, 0.1}).ok());
  EXPECT_EQ(signals.TicksAround(At(2000), At(2100)).stamp_offset_ns_size(), 0);
}

TEST(MotionSignalsTest, TheNewestHoldsForATenthOfASecond) {
  MotionSignals signals;
  ASSERT_TRUE(signals.Add({At(100), 10.0, 0.1}).ok());
  EXPECT_EQ(signals.VelocityAt(At(200))->linear_mps().x(), 10.0);
  EXPECT_EQ(signals.VelocityAt(At(0))->linear_mps().x(), 10.0);
  EXPECT_FALSE(signals.VelocityAt(At(201)).has_value());
  EXPECT_FALSE(signals.VelocityAt(At(-1)).has_value());
}

TEST(MotionSignalsTest, ALateTickStandsWhereItBelongs) {
  MotionSignals signals;
  ASSERT_TRUE(signals.Add({At(0), 10.0, 0.0}).ok());
  ASSERT_TRUE(signals.Add({At(40), 14.0, 0.0}).ok());
  EXPECT_DOUBLE_EQ(signals.VelocityAt(At(10))->linear_mps().x(), 11.0);
  ASSERT_TRUE(signals.Add({At(20), 20.0, 0.0}).ok());
  EXPECT_DOUBLE_EQ(signals.VelocityAt(At(10))->linear_mps().x(), 15.0);
}

TEST(MotionSignalsTest, AClockThatIsSetBackStartsOver) {
  MotionSignals signals;
  ASSERT_TRUE(signals.Add({At(10'000), 10.0, 0.0}).ok());
  ASSERT_TRUE(signals.Add({At(0), 14.0, 0.0}).ok());
  EXPECT_EQ(signals.VelocityAt(At(0))->linear_mps().x(), 14.0);
  EXPECT_FALSE(signals.VelocityAt(At(10'000)).has_value());
}

TEST(MotionSignalsTest, WhatCannotBeIsNamed) {
  MotionSignals signals;
  const auto error = [&](const MotionTick& tick) {
    return std::string(signals.Add(tick).message());
  };
  EXPECT_THAT(error({0, 1.0, 0.0}), HasSubstr("stamp_ns is 0"));
  EXPECT_THAT(error({1, 151.0, 0.0}), HasSubstr("speed_mps is 151; it must lie in [-150, 150]"));
  EXPECT_THAT(error({1, 1.0, -11.0}), HasSubstr("yaw_rate_radps is -11"));
  EXPECT_THAT(error({1, std::numeric_limits<double>::quiet_NaN(), 0.0}), HasSubstr("speed_mps"));
  EXPECT_THAT(error({1, std::nullopt, std::nullopt}), HasSubstr("neither"));
  EXPECT_FALSE(signals.VelocityAt(1).has_value()) << "nothing of them is taken";
}

}  // namespace
}  // namespace dcloc::client
