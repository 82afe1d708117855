#include "core/localizer/stamp_monitor.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <optional>

#include "tests/core/options/option_fields_check.h"

namespace dcloc {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

/// Radars that scan every 76 ms, each somewhat after the one before.
class StampMonitorTest : public ::testing::Test {
 protected:
  static constexpr std::size_t kRadars = 3;

  static Stamp TakenAt(int cycle, std::size_t radar) {
    return Stamp(std::chrono::seconds(1000)) + milliseconds(76 * cycle) + milliseconds(23) * radar;
  }

  /// Of `cycles` cycles, as `stamp_of(taken)` says; what is suspected of the first radar at last.
  template <typename StampOf>
  std::optional<nanoseconds> Drive(int cycles, const StampOf& stamp_of) {
    std::optional<nanoseconds> suspected;
    for (const int end = cycle_ + cycles; cycle_ < end; ++cycle_) {
      for (std::size_t radar = 0; radar < kRadars; ++radar) {
        const auto step = monitor_.OnStamp(radar, stamp_of(TakenAt(cycle_, radar), radar));
        if (radar == 0) suspected = step;
      }
    }
    return suspected;
  }
  std::optional<nanoseconds> Drive(int cycles) {
    return Drive(cycles, [](Stamp taken, std::size_t) { return taken; });
  }

  StampMonitor monitor_{kRadars, StampMonitorOptions{}};
  int cycle_ = 0;
};

TEST_F(StampMonitorTest, RegularStampsAreExact) {
  EXPECT_EQ(Drive(100), std::nullopt);
  for (std::size_t radar = 0; radar < kRadars; ++radar) {
    const StampError error = monitor_.ErrorOf(radar);
    EXPECT_EQ(error.bound_s, 0.0);
    EXPECT_EQ(error.sigma_s, 0.0);
    EXPECT_EQ(error.undecided_step_s, 0.0);
  }
}

TEST_F(StampMonitorTest, RoundedStampsAreKnownToBeOffByWhatTheyAreRounded) {
  StampMonitor alone(1, StampMonitorOptions{});
  for (int cycle = 0; cycle < 30; ++cycle) alone.OnStamp(0, TakenAt(cycle, 0));
  for (int cycle = 30; cycle < 90; ++cycle) {
    const nanoseconds since = TakenAt(cycle, 0).time_since_epoch() + milliseconds(25);
    const Stamp rounded(since / milliseconds(50) * milliseconds(50));
    EXPECT_EQ(alone.OnStamp(0, rounded), std::nullopt);
  }
  const StampError error = alone.ErrorOf(0);
  EXPECT_GT(error.bound_s, 0.015);
  EXPECT_LT(error.bound_s, 0.050);
  EXPECT_GT(error.sigma_s, 0.008);
  EXPECT_LT(error.sigma_s, 0.025);
  for (int cycle = 90; cycle < 290; ++cycle) alone.OnStamp(0, TakenAt(cycle, 0));
  EXPECT_EQ(alone.ErrorOf(0).bound_s, 0.0);
}

TEST_F(StampMonitorTest, AScanThatWasRefusedSaysNothing) {
  Drive(40);
  const StampError before = monitor_.ErrorOf(0);
  EXPECT_TRUE(monitor_.OnStamp(0, TakenAt(cycle_, 0) - milliseconds(600)).has_value());
  monitor_.Withdraw(0);
  EXPECT_EQ(monitor_.ErrorOf(0).undecided_step_s, before.undecided_step_s);
  EXPECT_EQ(monitor_.ErrorOf(0).bound_s, before.bound_s);
  EXPECT_EQ(Drive(1), std::nullopt);
}

TEST_F(StampMonitorTest, AStampThatRadarsShareIsThatOfACycle) {
  Drive(30);
  Drive(30, [&](Stamp, std::size_t) { return TakenAt(cycle_, 0); });
  for (std::size_t radar = 0; radar < kRadars; ++radar) {
    EXPECT_GE(monitor_.ErrorOf(radar).bound_s, 0.076);
    EXPECT_LT(monitor_.ErrorOf(radar).bound_s, 0.130);
  }
  Drive(100);
  EXPECT_EQ(monitor_.ErrorOf(1).bound_s, 0.0);
}

// Radars have periods of their own: now and then one measures before another, whose stamp it had
// borne, and takes that of the cycle before.
TEST_F(StampMonitorTest, AStampThatRadarsShareIsNoSignOfAClockThatWasSet) {
  Drive(40);
  int suspected = 0;
  int cycles_behind = 0;
  for (; cycle_ < 100; ++cycle_) {
    if (cycle_ % 20 == 0) ++cycles_behind;
    for (std::size_t radar = 0; radar < kRadars; ++radar) {
      const int behind = radar == 2 ? cycles_behind % 2 : 0;
      if (monitor_.OnStamp(radar, TakenAt(cycle_ - behind, 0))) ++suspected;
      EXPECT_EQ(monitor_.ErrorOf(radar).undecided_step_s, 0.0);
    }
  }
  EXPECT_EQ(suspected, 0);
}

TEST_F(StampMonitorTest, AClockThatWasSetIsSuspectedUntilScansDecide) {
  for (const milliseconds off : {milliseconds(200), milliseconds(-200)}) {
    Drive(40);
    const auto set = [&](Stamp taken, std::size_t radar) {
      return radar == 0 ? taken + off : taken;
    };
    const auto step = Drive(1, set);
    ASSERT_TRUE(step.has_value());
    EXPECT_LT(std::chrono::abs(*step - off), milliseconds(2));
    EXPECT_NEAR(monitor_.ErrorOf(0).undecided_step_s, 0.2, 0.002);
    EXPECT_FALSE(monitor_.OnFits(0, 0.3, 0.4)) << "too little";
    EXPECT_TRUE(Drive(1, set).has_value()) << "it lasts";
    EXPECT_TRUE(monitor_.OnFits(0, 0.3, 0.4));
    EXPECT_EQ(Drive(1, set), std::nullopt);
    Drive(1);  // set right
    EXPECT_FALSE(monitor_.OnFits(0, 0.6, 0.3)) << "its scan fits as it is stamped";
    EXPECT_EQ(monitor_.ErrorOf(0).undecided_step_s, 0.0);
  }
}

// After scans that are missing, as where a vehicle was carried, each radar goes on elsewhere in its
// period.
TEST_F(StampMonitorTest, RadarsThatLeaveTheirLinesTogetherHaveNoClockThatWasSet) {
  Drive(50);
  const auto seam = [](Stamp taken, std::size_t radar) {
    return taken + milliseconds(radar == 0 ? 50 : 10 * static_cast<int>(radar));
  };
  EXPECT_EQ(Drive(2, seam), std::nullopt);
  EXPECT_EQ(Drive(40, seam), std::nullopt);
}

TEST_F(StampMonitorTest, ClocksThatAreSetTogetherAreSuspected) {
  Drive(50);
  EXPECT_EQ(Drive(2, [](Stamp taken, std::size_t) { return taken + milliseconds(50); }),
            milliseconds(50));
}

TEST_F(StampMonitorTest, WhatNothingDecidesIsTakenAsStamped) {
  Drive(40);
  const auto set = [](Stamp taken, std::size_t) { return taken + milliseconds(200); };
  for (int i = 0; i < 30; ++i) {
    if (Drive(1, set)) {
      EXPECT_FALSE(monitor_.OnFits(0, 0.5, 0.5));
    }
  }
  EXPECT_EQ(monitor_.ErrorOf(0).undecided_step_s, 0.0);
}

TEST_F(StampMonitorTest, ScansThatArriveInAnyOrderSaySoOnce) {
  Drive(40);
  int suspected = 0;
  for (int i = 0; i < 40; ++i) {
    for (const int cycle : {cycle_ + 1, cycle_}) {
      if (monitor_.OnStamp(0, TakenAt(cycle, 0))) ++suspected;
    }
    cycle_ += 2;
  }
  EXPECT_LT(suspected, 10);
  EXPECT_EQ(monitor_.ErrorOf(0).bound_s, 0.0);
}

TEST(StampMonitorOptionsTest, EachFieldIsBounded) {
  ExpectEachFieldIsBounded<StampMonitorOptions>();
}

}  // namespace
}  // namespace dcloc
