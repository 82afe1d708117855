#include "core/uncertainty/along_track_rivals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/core/options/option_fields_check.h"

namespace dcloc {
namespace {

constexpr std::size_t kPointsOfAScan = 60;

// Scans fit the pose by `fit` and the places that lie a whole number of pitches away by
// `post_fit`; all others fit little. Whether one of them is better after so many scans.
bool IsBetterAfter(int scan_count, double fit, double post_fit, double noise = 0.0) {
  constexpr double kPitch_m = 4.0, kElsewhere = 0.2;
  AlongTrackRivals rivals({});
  std::mt19937 random(3);
  std::normal_distribution<double> error(0.0, noise);
  for (int scan = 0; scan < scan_count; ++scan) {
    std::vector<double> fits;
    for (const double offset_m : rivals.offsets_m()) {
      const bool is_post = std::abs(std::remainder(offset_m, kPitch_m)) < 0.1;
      fits.push_back((is_post ? post_fit : kElsewhere) + (noise > 0.0 ? error(random) : 0.0));
    }
    rivals.OnFits(kPointsOfAScan, false, fit, fits);
    if (rivals.has_better()) return true;
  }
  return false;
}

TEST(AlongTrackRivalOptionsTest, EachFieldIsBounded) {
  ExpectEachFieldIsBounded<AlongTrackRivalOptions>();
}

TEST(AlongTrackRivalsTest, PlacesLieOnBothSides) {
  const AlongTrackRivals rivals({.step_m = 1.0, .min_offset_m = 2.0, .max_offset_m = 3.0});
  EXPECT_EQ(std::vector<double>(rivals.offsets_m().begin(), rivals.offsets_m().end()),
            (std::vector<double>{2.0, -2.0, 3.0, -3.0}));
}

TEST(AlongTrackRivalsTest, APostThatFitsBetterIsFoundWithinAFewScans) {
  EXPECT_TRUE(IsBetterAfter(8, 0.36, 0.50));
}

TEST(AlongTrackRivalsTest, ASingleScanDoesNotDecide) { EXPECT_FALSE(IsBetterAfter(1, 0.1, 0.9)); }

TEST(AlongTrackRivalsTest, PostsThatFitAsWellOrLessAreNotBetter) {
  EXPECT_FALSE(IsBetterAfter(1000, 0.50, 0.38, 0.04));
  EXPECT_FALSE(IsBetterAfter(1000, 0.50, 0.50));
}

TEST(AlongTrackRivalsTest, WhatIsForgottenSpeaksForNoPlace) {
  AlongTrackRivals rivals({.step_m = 1.0, .min_offset_m = 2.0, .max_offset_m = 2.0});
  const std::vector<double> fits = {0.6, 0.1};
  const auto lay = [&](int count) {
    for (int i = 0; i < count; ++i) rivals.OnFits(kPointsOfAScan, false, 0.4, fits);
  };
  lay(3);
  rivals.Reset();
  lay(3);
  EXPECT_FALSE(rivals.has_better());
  lay(3);
  EXPECT_TRUE(rivals.has_better());
}

TEST(AlongTrackRivalsTest, ARivalThatFitsLessAgainIsNotBetterAnyMore) {
  AlongTrackRivals rivals({.step_m = 1.0, .min_offset_m = 2.0, .max_offset_m = 2.0});
  for (int i = 0; i < 100; ++i) rivals.OnFits(kPointsOfAScan, false, 0.4, std::vector{0.6, 0.1});
  EXPECT_TRUE(rivals.has_better());
  for (int i = 0; i < 2; ++i) rivals.OnFits(kPointsOfAScan, false, 0.5, std::vector{0.4, 0.4});
  EXPECT_FALSE(rivals.has_better());
}

TEST(AlongTrackRivalsTest, AConfirmedPoseIsComparedForAWhile) {
  AlongTrackRivals rivals(
      {.step_m = 1.0, .min_offset_m = 2.0, .max_offset_m = 2.0, .scan_count = 2});
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
