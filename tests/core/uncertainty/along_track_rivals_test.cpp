#include "core/uncertainty/along_track_rivals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>
#include <span>
#include <vector>

#include "tests/core/options/option_fields_check.h"

namespace dcloc {
namespace {

constexpr std::size_t kPointsOfAScan = 60;

// 2, 3 and 4 m ahead and behind.
AlongTrackRivalOptions SixPlaces(int places_per_scan) {
  return {.step_m = 1.0,
          .min_offset_m = 2.0,
          .max_offset_m = 4.0,
          .places_per_scan = places_per_scan,
          .beginning_rounds = 0};
}

std::vector<double> Next(AlongTrackRivals& rivals) {
  const std::span<const double> offsets_m = rivals.NextOffsets_m();
  return {offsets_m.begin(), offsets_m.end()};
}

// Compares a scan that fits the pose by `fit` and the place at `rival_m` by `rival_fit`; all others
// fit little.
void Compare(AlongTrackRivals& rivals, double fit, double rival_m, double rival_fit) {
  std::vector<double> fits;
  for (const double offset_m : rivals.NextOffsets_m()) {
    fits.push_back(offset_m == 0.0 ? fit : offset_m == rival_m ? rival_fit : 0.1);
  }
  rivals.OnFits(kPointsOfAScan, fits);
}

// Scans fit the pose by `fit` and the places that lie a whole number of pitches away by
// `post_fit`; all others fit little. Whether one of them is better after so many scans.
bool IsBetterAfter(int scan_count, double fit, double post_fit, double noise = 0.0) {
  constexpr double kPitch_m = 4.0, kElsewhere = 0.2;
  AlongTrackRivals rivals({});
  std::mt19937 random(3);
  std::normal_distribution<double> error(0.0, noise);
  for (int scan = 0; scan < scan_count; ++scan) {
    std::vector<double> fits;
    for (const double offset_m : rivals.NextOffsets_m()) {
      const bool is_post = std::abs(std::remainder(offset_m, kPitch_m)) < 0.1;
      fits.push_back((is_post ? post_fit : kElsewhere) + (noise > 0.0 ? error(random) : 0.0));
    }
    fits.front() = fit;
    rivals.OnFits(kPointsOfAScan, fits);
    if (rivals.has_better()) return true;
  }
  return false;
}

TEST(AlongTrackRivalOptionsTest, EachFieldIsBounded) {
  ExpectEachFieldIsBounded<AlongTrackRivalOptions>();
}

TEST(AlongTrackRivalsTest, PlacesLieOnBothSidesOfThePose) {
  AlongTrackRivals rivals(SixPlaces(6));
  EXPECT_EQ(Next(rivals), (std::vector{0.0, 2.0, -2.0, 3.0, -3.0, 4.0, -4.0}));
}

TEST(AlongTrackRivalsTest, PlacesTakeTurns) {
  AlongTrackRivals rivals(SixPlaces(4));
  EXPECT_EQ(Next(rivals), (std::vector{0.0, 2.0, -2.0, 3.0, -3.0}));
  EXPECT_EQ(Next(rivals), (std::vector{0.0, 4.0, -4.0, 2.0, -2.0}));
}

TEST(AlongTrackRivalsTest, APlaceThatHasFittedBetterIsComparedEachTime) {
  AlongTrackRivals rivals(SixPlaces(2));
  Compare(rivals, 0.4, 2.0, 0.6);
  EXPECT_EQ(Next(rivals), (std::vector{0.0, 2.0, 3.0}));
  EXPECT_EQ(Next(rivals), (std::vector{0.0, 2.0, -3.0}));
}

TEST(AlongTrackRivalsTest, ThoseThatHaveFittedBetterLeaveTheOthersTheirTurns) {
  AlongTrackRivals rivals(SixPlaces(4));
  for (int i = 0; i < 3; ++i) {  // all of them
    std::vector<double> fits(rivals.NextOffsets_m().size(), 0.5);
    fits.front() = 0.4;
    rivals.OnFits(kPointsOfAScan, fits);
  }
  std::set<double> seen;
  for (int i = 0; i < 3; ++i) {
    for (const double offset_m : Next(rivals)) seen.insert(offset_m);
  }
  EXPECT_EQ(seen.size(), 1 + 6);
}

TEST(AlongTrackRivalsTest, APoseThatBeginsIsComparedAtMorePlaces) {
  AlongTrackRivalOptions options = SixPlaces(2);
  options.beginning_factor = 2;
  options.beginning_rounds = 2;
  AlongTrackRivals rivals(options);
  const auto count = [&] { return rivals.NextOffsets_m().size(); };
  for (int scan = 0; scan < 3; ++scan) EXPECT_EQ(count(), 1 + 4);  // two rounds of six places
  EXPECT_EQ(count(), 1 + 2);
  rivals.Reset();
  EXPECT_EQ(count(), 1 + 4);
}

TEST(AlongTrackRivalsTest, WithoutADistanceThereAreNone) {
  AlongTrackRivals rivals({.max_offset_m = 0.0});
  EXPECT_TRUE(rivals.NextOffsets_m().empty());
  EXPECT_FALSE(rivals.has_better());
}

// At the beginning a round of all places takes six scans.
TEST(AlongTrackRivalsTest, APostThatFitsBetterIsFoundWithinARoundAndAFewScans) {
  EXPECT_TRUE(IsBetterAfter(12, 0.36, 0.50));
}

TEST(AlongTrackRivalsTest, ASingleScanDoesNotDecide) { EXPECT_FALSE(IsBetterAfter(1, 0.1, 0.9)); }

TEST(AlongTrackRivalsTest, PostsThatFitAsWellOrLessAreNotBetter) {
  EXPECT_FALSE(IsBetterAfter(1000, 0.50, 0.38, 0.04));
  EXPECT_FALSE(IsBetterAfter(1000, 0.50, 0.50));
}

TEST(AlongTrackRivalsTest, WhatIsForgottenSpeaksForNoPlace) {
  AlongTrackRivals rivals(SixPlaces(6));
  const auto compare = [&](int count) {
    for (int i = 0; i < count; ++i) Compare(rivals, 0.4, 2.0, 0.6);
  };
  compare(2);
  rivals.Reset();
  compare(2);
  EXPECT_FALSE(rivals.has_better());
  compare(2);
  EXPECT_TRUE(rivals.has_better());
}

TEST(AlongTrackRivalsTest, ARivalThatFitsLessAgainIsNotBetterAnyMore) {
  AlongTrackRivals rivals(SixPlaces(6));
  for (int i = 0; i < 100; ++i) Compare(rivals, 0.4, 2.0, 0.6);
  EXPECT_TRUE(rivals.has_better());
  for (int i = 0; i < 2; ++i) Compare(rivals, 0.5, 2.0, 0.4);
  EXPECT_FALSE(rivals.has_better());
}

TEST(AlongTrackRivalsTest, GroundRepeatsWhereRivalsFitNearlyAsWell) {
  AlongTrackRivals rivals({});
  EXPECT_FALSE(rivals.ground_repeats()) << "nothing is known";
  const std::vector<double> town = {0.5, 0.1, 0.15, 0.0};
  const std::vector<double> highway = {0.5, 0.1, 0.35, 0.2};
  for (int i = 0; i < 30; ++i) rivals.LearnRepetition(town);
  EXPECT_FALSE(rivals.ground_repeats());
  for (int i = 0; i < 30; ++i) rivals.LearnRepetition(highway);
  EXPECT_TRUE(rivals.ground_repeats());
  rivals.Reset();
  EXPECT_TRUE(rivals.ground_repeats()) << "it is the same ground";
}

}  // namespace
}  // namespace dcloc
