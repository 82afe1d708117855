#include "core/uncertainty/way_rivals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>
#include <vector>

namespace dcloc {
namespace {

constexpr std::size_t kPointsOfAScan = 60;

// Scans fit the pose by `fit` and the places that lie a whole number of pitches away by
// `post_fit`; all others fit little. The way to the place that is better after so many scans.
std::optional<double> BetterAfter(int scan_count, double fit, double post_fit, double noise = 0.0) {
  constexpr double kPitch_m = 4.0, kElsewhere = 0.2;
  WayRivals rivals({});
  std::mt19937 random(3);
  std::normal_distribution<double> error(0.0, noise);
  for (int scan = 0; scan < scan_count; ++scan) {
    std::vector<double> fits;
    for (const double way_m : rivals.ways_m()) {
      const bool is_post = std::abs(std::remainder(way_m, kPitch_m)) < 0.1;
      fits.push_back((is_post ? post_fit : kElsewhere) + (noise > 0.0 ? error(random) : 0.0));
    }
    rivals.OnFits(kPointsOfAScan, false, fit, fits);
    if (rivals.Better()) return rivals.Better();
  }
  return std::nullopt;
}

TEST(WayRivalsTest, PlacesLieOnBothSides) {
  const WayRivals rivals({.step_m = 1.0, .min_way_m = 2.0, .max_way_m = 3.0});
  EXPECT_EQ(std::vector<double>(rivals.ways_m().begin(), rivals.ways_m().end()),
            (std::vector<double>{2.0, -2.0, 3.0, -3.0}));
}

TEST(WayRivalsTest, APostThatFitsBetterIsFoundWithinAFewScans) {
  const std::optional<double> better = BetterAfter(4, 0.38, 0.50);
  ASSERT_TRUE(better);
  EXPECT_EQ(std::remainder(*better, 4.0), 0.0);
}

TEST(WayRivalsTest, ASingleScanDoesNotDecide) { EXPECT_FALSE(BetterAfter(1, 0.1, 0.9)); }

TEST(WayRivalsTest, PostsThatFitAsWellOrLessAreNotBetter) {
  EXPECT_FALSE(BetterAfter(1000, 0.50, 0.38, 0.04));
  EXPECT_FALSE(BetterAfter(1000, 0.50, 0.50));
}

TEST(WayRivalsTest, WhatIsForgottenSpeaksForNoPlace) {
  WayRivals rivals({.step_m = 1.0, .min_way_m = 2.0, .max_way_m = 2.0});
  const std::vector<double> fits = {0.6, 0.1};
  rivals.OnFits(kPointsOfAScan, false, 0.4, fits);
  rivals.OnFits(kPointsOfAScan, false, 0.4, fits);
  rivals.Reset();
  rivals.OnFits(kPointsOfAScan, false, 0.4, fits);
  EXPECT_FALSE(rivals.Better());
  rivals.OnFits(kPointsOfAScan, false, 0.4, fits);
  rivals.OnFits(kPointsOfAScan, false, 0.4, fits);
  EXPECT_EQ(rivals.Better(), 2.0);
}

TEST(WayRivalsTest, AConfirmedPoseIsComparedForAWhile) {
  WayRivals rivals({.step_m = 1.0, .min_way_m = 2.0, .max_way_m = 2.0, .scan_count = 2});
  const std::vector<double> fits = {0.1, 0.1};
  rivals.OnFits(kPointsOfAScan, true, 0.4, fits);
  EXPECT_TRUE(rivals.IsDue(true));
  rivals.OnFits(kPointsOfAScan, true, 0.4, fits);
  EXPECT_FALSE(rivals.IsDue(true));
  EXPECT_TRUE(rivals.IsDue(false));
  rivals.OnFits(kPointsOfAScan, false, 0.4, fits);
  EXPECT_TRUE(rivals.IsDue(true));
}

}  // namespace
}  // namespace dcloc
