#include "server/sessions/health_watch.h"

#include <gtest/gtest.h>

namespace dcloc::server {
namespace {

using std::chrono::seconds;

constexpr SourceHealth kGood{.is_used = true, .fault = SourceFault::kNone};
constexpr SourceHealth kSlips{.is_used = false, .fault = SourceFault::kSlip};
constexpr SourceHealth kSilent{.is_used = false, .fault = SourceFault::kSilent};

class HealthWatchTest : public ::testing::Test {
 protected:
  /// News of the wheels alone, `after` the scan before.
  HealthChanges Wheels(const SourceHealth& health, seconds after = seconds(1)) {
    now_ += after;
    return watch_.Observe({.wheel_speed = health, .yaw_rate = {}, .radars = {}}, resets_, now_);
  }

  HealthWatch watch_;
  PoseResets resets_;
  HealthWatch::Clock::time_point now_{std::chrono::hours(1)};
};

TEST_F(HealthWatchTest, ASourceIsToldOnceWhenItIsSetAsideAndOnceWhenItIsTakenBack) {
  EXPECT_TRUE(Wheels(kGood).sources.empty());
  const HealthChanges aside = Wheels(kSlips);
  ASSERT_EQ(aside.sources.size(), 1U);
  EXPECT_EQ(aside.sources[0].kind, SourceKind::kWheelSpeed);
  EXPECT_EQ(aside.sources[0].health, kSlips);
  EXPECT_EQ(aside.sources[0].change_count, 1);
  EXPECT_TRUE(Wheels(kSlips, seconds(60)).sources.empty());
  const HealthChanges back = Wheels(kGood);
  ASSERT_EQ(back.sources.size(), 1U);
  EXPECT_TRUE(back.sources[0].health.is_used);
  EXPECT_FALSE(back.set_aside[0]);
}

TEST_F(HealthWatchTest, ASourceThatFlapsIsToldAtMostOnceInTenSeconds) {
  int told = 0;
  int changes = 0;
  for (int i = 0; i < 60; ++i) {
    for (const SourceChange& change : Wheels(i % 2 == 0 ? kSlips : kGood).sources) {
      ++told;
      changes += change.change_count;
    }
  }
  EXPECT_GE(told, 3);
  EXPECT_LE(told, 6);
  EXPECT_GE(changes, 40) << "those between are counted";
}

TEST_F(HealthWatchTest, WhatHasNeverSpokenIsNotMissed) {
  const HealthChanges never = Wheels(kSilent);
  EXPECT_TRUE(never.sources.empty());
  EXPECT_FALSE(never.set_aside[0]);
  Wheels(kGood);
  const HealthChanges fell_silent = Wheels(kSilent);
  EXPECT_EQ(fell_silent.sources.size(), 1U);
  EXPECT_TRUE(fell_silent.set_aside[0]);
}

TEST_F(HealthWatchTest, AnotherReasonIsToldAndACorrectedSourceIsNot) {
  Wheels(kSlips);
  const SourceHealth scaled{.is_used = false, .fault = SourceFault::kScale};
  ASSERT_EQ(Wheels(scaled, seconds(10)).sources.size(), 1U);
  ASSERT_EQ(Wheels(kGood, seconds(10)).sources.size(), 1U);
  const SourceHealth corrected{.is_used = true, .fault = SourceFault::kScale};
  EXPECT_TRUE(Wheels(corrected, seconds(10)).sources.empty());
}

TEST_F(HealthWatchTest, RadarsAreToldApart) {
  Health health;
  health.radars.resize(3, kGood);
  watch_.Observe(health, {}, now_);
  health.radars[1] = {.is_used = false, .fault = SourceFault::kMount};
  const HealthChanges changes = watch_.Observe(health, {}, now_);
  ASSERT_EQ(changes.sources.size(), 1U);
  EXPECT_EQ(changes.sources[0].kind, SourceKind::kRadar);
  EXPECT_EQ(changes.sources[0].radar_index, 1U);
  EXPECT_TRUE(changes.set_aside[2]);
}

TEST_F(HealthWatchTest, EveryResetIsCountedAndOneInTenSecondsTold) {
  EXPECT_EQ(Wheels(kGood).new_reset_count, 0);
  resets_.count = 2;
  const HealthChanges first = Wheels(kGood);
  EXPECT_EQ(first.new_reset_count, 2);
  EXPECT_TRUE(first.reset_is_logged);
  resets_.count = 3;
  const HealthChanges second = Wheels(kGood);
  EXPECT_EQ(second.new_reset_count, 1);
  EXPECT_FALSE(second.reset_is_logged);
  resets_.count = 4;
  EXPECT_TRUE(Wheels(kGood, seconds(10)).reset_is_logged);
}

}  // namespace
}  // namespace dcloc::server
