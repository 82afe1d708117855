#include "server/sessions/version_trial.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "absl/strings/str_cat.h"

namespace dcloc::server {
namespace {

/// `count` vehicles whose shares lie about `share`.
VersionTally Vehicles(int count, double share, int looks = 300, std::uint64_t seed = 1) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0.0, 0.02);
  VersionTally tally;
  for (int i = 0; i < count; ++i) {
    const double own = std::clamp(share + noise(random), 0.0, 1.0);
    tally[absl::StrCat("car-", i)] = {.looks = looks,
                                      .tracking = static_cast<int>(std::round(own * looks))};
  }
  return tally;
}

TEST(VersionTrialTest, AWorseCanaryIsFound) {
  const Trial trial = CompareVersions(Vehicles(6, 0.8), Vehicles(40, 0.97, 300, 2), {});
  EXPECT_TRUE(trial.is_canary_worse);
  EXPECT_EQ(trial.canary_vehicles, 6U);
  EXPECT_EQ(trial.active_vehicles, 40U);
  EXPECT_NEAR(trial.canary_share, 0.8, 0.03);
  EXPECT_GT(trial.sigmas, 3.0);
}

TEST(VersionTrialTest, OneThatIsAsGoodOrBetterStays) {
  int withdrawn = 0;
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    const VersionTally canary = Vehicles(10, 0.95, 300, seed);
    withdrawn += CompareVersions(canary, Vehicles(90, 0.95, 300, seed + 1000), {}).is_canary_worse;
  }
  EXPECT_LE(withdrawn, 2);
  EXPECT_FALSE(CompareVersions(Vehicles(10, 0.99), Vehicles(90, 0.9, 300, 2), {}).is_canary_worse);
}

TEST(VersionTrialTest, WhatIsSureButDoesNotMatterStays) {
  VersionTally canary, active;
  for (int i = 0; i < 50; ++i) {
    canary[absl::StrCat(i)] = {.looks = 1000, .tracking = 990};
    active[absl::StrCat(i)] = {.looks = 1000, .tracking = 1000};
  }
  const Trial trial = CompareVersions(canary, active, {});
  EXPECT_GT(trial.sigmas, 3.0);
  EXPECT_FALSE(trial.is_canary_worse);
}

TEST(VersionTrialTest, FewVehiclesOrFewLooksSayNothing) {
  EXPECT_FALSE(CompareVersions(Vehicles(4, 0.1), Vehicles(40, 0.97, 300, 2), {}).is_canary_worse);
  EXPECT_FALSE(CompareVersions(Vehicles(9, 0.1, 30), Vehicles(40, 0.97), {}).is_canary_worse);
  EXPECT_FALSE(CompareVersions({}, {}, {}).is_canary_worse);
}

TEST(VersionTrialTest, EqualSharesHaveNoRank) {
  VersionTally all;
  for (int i = 0; i < 10; ++i) all[absl::StrCat(i)] = {.looks = 100, .tracking = 100};
  EXPECT_EQ(CompareVersions(all, all, {}).sigmas, 0.0);
}

}  // namespace
}  // namespace dcloc::server
