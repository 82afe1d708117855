#include "core/odometry/tick_motion.h"

#include <gtest/gtest.h>

#include <chrono>
#include <vector>

#include "core/geometry/covariance.h"

namespace dcloc {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kAge{100};

TEST(TickMotionTest, AVelocityOnALineTellsNothingMore) {
  const std::vector<MotionTick> ticks = {{milliseconds(-100), 10.0, 0.0},
                                         {milliseconds(-50), 11.0, 0.0},
                                         {milliseconds(0), 12.0, 0.0}};
  const auto beyond = BeyondTheLine(ticks, kAge);
  ASSERT_TRUE(beyond.has_value());
  EXPECT_NEAR(Log(*beyond).norm(), 0.0, 1e-12);
}

TEST(TickMotionTest, AHaltBetweenTwoScansIsSeen) {
  // It drives at both ends, and stands in between: 0.5 m where the ends alone would say 1 m.
  const std::vector<MotionTick> ticks = {
      {milliseconds(-100), 10.0, 0.0}, {milliseconds(-50), 0.0, 0.0}, {milliseconds(0), 10.0, 0.0}};
  const auto beyond = BeyondTheLine(ticks, kAge);
  ASSERT_TRUE(beyond.has_value());
  EXPECT_NEAR(beyond->translation_m.x(), -0.5, 1e-12);
}

TEST(TickMotionTest, AConstantErrorOfTheTicksIsNoPartOfIt) {
  std::vector<MotionTick> ticks = {{milliseconds(-100), 10.0, 0.0},
                                   {milliseconds(-50), 9.0, 0.02},
                                   {milliseconds(0), 10.0, 0.0}};
  const auto beyond = BeyondTheLine(ticks, kAge);
  for (MotionTick& tick : ticks) tick.yaw_rate_radps += 0.1;
  const auto biased = BeyondTheLine(ticks, kAge);
  ASSERT_TRUE(beyond.has_value() && biased.has_value());
  EXPECT_NEAR((Log(*beyond) - Log(*biased)).norm(), 0.0, 5e-4);
}

TEST(TickMotionTest, MomentsBetweenTicksTakeTheirShare) {
  const std::vector<MotionTick> ticks = {
      {milliseconds(-130), 7.0, 0.0}, {milliseconds(-50), 15.0, 0.0}, {milliseconds(30), 7.0, 0.0}};
  const auto beyond = BeyondTheLine(ticks, kAge);
  ASSERT_TRUE(beyond.has_value());
  // 10 m/s at both ends, 15 m/s half-way.
  EXPECT_NEAR(beyond->translation_m.x(), 0.25, 1e-12);
}

TEST(TickMotionTest, TicksThatDoNotReachOrHaveAGapAreOfNoUse) {
  const auto tells = [](int first_ms, int middle_ms, int last_ms) {
    return BeyondTheLine(std::vector<MotionTick>{{milliseconds(first_ms), 10.0, 0.0},
                                                 {milliseconds(middle_ms), 0.0, 0.0},
                                                 {milliseconds(last_ms), 10.0, 0.0}},
                         kAge)
        .has_value();
  };
  EXPECT_TRUE(tells(-100, -60, 0));
  EXPECT_FALSE(tells(-99, -60, 0));
  EXPECT_TRUE(tells(-100, -60, -50));
  EXPECT_FALSE(tells(-100, -60, -51));
  EXPECT_FALSE(tells(-311, -60, 0));
  EXPECT_FALSE(BeyondTheLine({}, kAge).has_value());
  EXPECT_FALSE(BeyondTheLine(std::vector<MotionTick>{{milliseconds(0), 10.0, 0.0}},
                             std::chrono::nanoseconds(0))
                   .has_value());
}

}  // namespace
}  // namespace dcloc
