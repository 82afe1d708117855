#include "core/odometry/tick_motion.h"

#include <gtest/gtest.h>

#include <chrono>
#include <vector>

#include "core/geometry/covariance.h"

namespace dcloc {
namespace {

using std::chrono::milliseconds;

Stamp TickStamp(int time_ms) { return Stamp(std::chrono::seconds(1000) + milliseconds(time_ms)); }

TEST(TickMotionTest, AVelocityOnALineTellsNothingMore) {
  const std::vector<MotionTick> ticks = {
      {TickStamp(0), 10.0, 0.0}, {TickStamp(50), 11.0, 0.0}, {TickStamp(100), 12.0, 0.0}};
  const auto beyond = BeyondTheLine(ticks, TickStamp(0), TickStamp(100));
  ASSERT_TRUE(beyond.has_value());
  EXPECT_NEAR(Log(*beyond).norm(), 0.0, 1e-12);
}

TEST(TickMotionTest, AHaltBetweenTwoScansIsSeen) {
  // It drives at both ends, and stands in between: 0.5 m where the ends alone would say 1 m.
  const std::vector<MotionTick> ticks = {
      {TickStamp(0), 10.0, 0.0}, {TickStamp(50), 0.0, 0.0}, {TickStamp(100), 10.0, 0.0}};
  const auto beyond = BeyondTheLine(ticks, TickStamp(0), TickStamp(100));
  ASSERT_TRUE(beyond.has_value());
  EXPECT_NEAR(beyond->translation_m.x(), -0.5, 1e-12);
}

TEST(TickMotionTest, AConstantErrorOfTheTicksIsNoPartOfIt) {
  std::vector<MotionTick> ticks = {
      {TickStamp(0), 10.0, 0.0}, {TickStamp(50), 9.0, 0.02}, {TickStamp(100), 10.0, 0.0}};
  const auto beyond = BeyondTheLine(ticks, TickStamp(0), TickStamp(100));
  for (MotionTick& tick : ticks) tick.yaw_rate_radps += 0.1;
  const auto biased = BeyondTheLine(ticks, TickStamp(0), TickStamp(100));
  ASSERT_TRUE(beyond.has_value() && biased.has_value());
  EXPECT_NEAR((Log(*beyond) - Log(*biased)).norm(), 0.0, 5e-4);
}

TEST(TickMotionTest, MomentsBetweenTicksTakeTheirShare) {
  const std::vector<MotionTick> ticks = {
      {TickStamp(-30), 7.0, 0.0}, {TickStamp(50), 15.0, 0.0}, {TickStamp(130), 7.0, 0.0}};
  const auto beyond = BeyondTheLine(ticks, TickStamp(0), TickStamp(100));
  ASSERT_TRUE(beyond.has_value());
  // 10 m/s at both ends, 15 m/s half-way.
  EXPECT_NEAR(beyond->translation_m.x(), 0.25, 1e-12);
}

TEST(TickMotionTest, TicksThatDoNotReachOrHaveAGapAreOfNoUse) {
  const std::vector<MotionTick> ticks = {
      {TickStamp(0), 10.0, 0.0}, {TickStamp(50), 0.0, 0.0}, {TickStamp(100), 10.0, 0.0}};
  EXPECT_FALSE(BeyondTheLine({}, TickStamp(0), TickStamp(100)).has_value());
  EXPECT_FALSE(BeyondTheLine(ticks, TickStamp(-1), TickStamp(100)).has_value());
  EXPECT_TRUE(BeyondTheLine(ticks, TickStamp(0), TickStamp(150)).has_value());
  EXPECT_FALSE(BeyondTheLine(ticks, TickStamp(0), TickStamp(151)).has_value());
  EXPECT_FALSE(BeyondTheLine(ticks, TickStamp(100), TickStamp(100)).has_value());
  const std::vector<MotionTick> gap = {{TickStamp(0), 10.0, 0.0}, {TickStamp(251), 10.0, 0.0}};
  EXPECT_FALSE(BeyondTheLine(gap, TickStamp(0), TickStamp(251)).has_value());
}

}  // namespace
}  // namespace dcloc
