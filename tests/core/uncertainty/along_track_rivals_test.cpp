#include "core/uncertainty/along_track_rivals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
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

// How far each of the places on a straight road lies ahead of the pose.
std::vector<double> Next(AlongTrackRivals& rivals) {
  std::vector<double> offsets_m;
  for (const Pose2& place : rivals.NextPlaces(0.0)) offsets_m.push_back(place.translation_m.x());
  return offsets_m;
}

// Compares a scan that fits the pose by `fit` and the place at `rival_m` by `rival_fit`; all others
// fit little.
void Compare(AlongTrackRivals& rivals, double fit, double rival_m, double rival_fit) {
  std::vector<double> fits;
  for (const double offset_m : Next(rivals)) {
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
    for (const double offset_m : Next(rivals)) {
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

// How many of the next six scans of each of two radars, which scan in turn, are compared.
int CompareOfSix(AlongTrackRivals rivals, bool in_doubt = false) {
  int count = 0, other_count = 0;
  for (int scan = 0; scan < 6; ++scan) {
    count += rivals.IsDue(0, in_doubt) ? 1 : 0;
    other_count += rivals.IsDue(1, in_doubt) ? 1 : 0;
  }
  EXPECT_EQ(other_count, count);
  return count;
}

TEST(AlongTrackRivalsTest, FewerScansAreComparedWhereAllIsAsUsual) {
  AlongTrackRivalOptions options = SixPlaces(6);
  options.registrations_per_rival = 0;
  AlongTrackRivals rivals(options);
  EXPECT_EQ(CompareOfSix(rivals), 6) << "nothing is known of the ground";
  const std::vector<double> like_no_other = {0.6, 0.2}, like_another = {0.6, 0.5};
  for (int scan = 0; scan < 10; ++scan) rivals.LearnRepetition(like_no_other);
  EXPECT_EQ(CompareOfSix(rivals), 2);
  EXPECT_EQ(CompareOfSix(rivals, /*in_doubt=*/true), 6);
  EXPECT_EQ(CompareOfSix(AlongTrackRivals({})), 6) << "a pose begins";

  AlongTrackRivals one_fits_better = rivals;
  Compare(one_fits_better, 0.3, 3.0, 0.6);
  EXPECT_EQ(CompareOfSix(one_fits_better), 6);
  rivals.LearnRepetition(like_another);
  EXPECT_FALSE(rivals.ground_repeats());
  EXPECT_EQ(CompareOfSix(rivals), 6) << "the newest scan fits another place, too";
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
    std::vector<double> fits(Next(rivals).size(), 0.5);
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
  const auto count = [&] { return Next(rivals).size(); };
  for (int scan = 0; scan < 3; ++scan) EXPECT_EQ(count(), 1 + 4);  // two rounds of six places
  EXPECT_EQ(count(), 1 + 2);
  rivals.Reset();
  EXPECT_EQ(count(), 1 + 4);
}

TEST(AlongTrackRivalsTest, PlacesFollowTheBendOfTheRoad) {
  constexpr double kRadius_m = 2.0;
  AlongTrackRivals rivals(SixPlaces(6));
  const std::span<const Pose2> places = rivals.NextPlaces(1.0 / kRadius_m);
  const Eigen::Vector2d center_m(0.0, kRadius_m);
  for (const Pose2& place : places) {
    EXPECT_NEAR((place.translation_m - center_m).norm(), kRadius_m, 1e-12);
    const Eigen::Vector2d ahead = place.Rotation().col(0);
    EXPECT_NEAR(ahead.dot(place.translation_m - center_m), 0.0, 1e-12) << "the road's direction";
  }
  EXPECT_NEAR(places[1].yaw_rad, 2.0 / kRadius_m, 1e-12);
  EXPECT_NEAR(places[2].yaw_rad, -2.0 / kRadius_m, 1e-12);
}

// How far the next rival to be registered lies ahead; 0 if there is none.
double NextToRegister_m(AlongTrackRivals& rivals) {
  const std::optional<Pose2> place = rivals.NextToRegister();
  return place ? place->translation_m.x() : 0.0;
}

// A pose that stands out has beaten three rivals in a row.
void BeatThree(AlongTrackRivals& rivals) {
  rivals.SupposeThatItStandsOut();
  for (int i = 0; i < 3; ++i) {
    Compare(rivals, 0.5, 3.0, 0.4);
    EXPECT_NE(NextToRegister_m(rivals), 0.0);
    rivals.OnRegistered({.translation_m = {0.0, 0.0}}, -0.1);
  }
}

TEST(AlongTrackRivalsTest, ARivalIsRegisteredNowAndThen) {
  AlongTrackRivalOptions options = SixPlaces(6);
  options.registrations_per_rival = 2;
  AlongTrackRivals rivals(options);
  BeatThree(rivals);
  Compare(rivals, 0.4, 3.0, 0.6);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(rivals.CountToRegister(), 0);
    EXPECT_EQ(rivals.CountToRegister(), 1);
    EXPECT_EQ(NextToRegister_m(rivals), 3.0);
  }
}

TEST(AlongTrackRivalsTest, OnceOneIsNotBeatenTheOthersTakeTurnsUntilSomeAre) {
  AlongTrackRivalOptions options = SixPlaces(6);
  options.max_shift_m = 0.5;  // six places of their own
  AlongTrackRivals rivals(options);
  const auto register_one = [&] {
    Compare(rivals, 0.5, 3.0, 0.45);
    const double rival_m = NextToRegister_m(rivals);
    rivals.OnRegistered({.translation_m = {rival_m, 0.0}}, 0.0);
    return rival_m;
  };
  BeatThree(rivals);
  register_one();
  std::set<double> registered_m;
  for (int i = 0; i < 8; ++i) {  // every fifth is the one that scans fit best
    EXPECT_EQ(rivals.CountToRegister(), 1);
    registered_m.insert(register_one());
  }
  EXPECT_EQ(registered_m.size(), 6U);
  BeatThree(rivals);
  EXPECT_EQ(rivals.CountToRegister(), 0);
}

TEST(AlongTrackRivalsTest, APoseThatBeginsWaitsWhileARivalLeads) {
  AlongTrackRivalOptions options = SixPlaces(6);
  options.beginning_rounds = 2;
  AlongTrackRivals rivals(options);
  rivals.SupposeThatItStandsOut();
  Compare(rivals, 0.4, 3.0, 0.3);
  EXPECT_TRUE(rivals.stands_out());
  EXPECT_EQ(NextToRegister_m(rivals), 3.0) << "whether the ground repeats is not known yet";
  rivals.OnRegistered({.translation_m = {3.0, 0.0}}, 0.1);
  EXPECT_FALSE(rivals.stands_out());
  Compare(rivals, 0.4, 3.0, 0.3);
  EXPECT_TRUE(rivals.stands_out()) << "it has begun";
}

TEST(AlongTrackRivalsTest, ARivalThatHasNotFittedBetterIsRegisteredWhereTheGroundRepeats) {
  AlongTrackRivals rivals(SixPlaces(6));
  rivals.SupposeThatItStandsOut();
  EXPECT_EQ(NextToRegister_m(rivals), 0.0) << "nothing is known";
  for (const double rival_fit : {0.15, 0.35}) {
    for (int i = 0; i < 30; ++i) {
      Compare(rivals, 0.5, 3.0, rival_fit);
      rivals.LearnRepetition(std::vector{0.5, rival_fit});
    }
    EXPECT_EQ(NextToRegister_m(rivals), rivals.ground_repeats() ? 3.0 : 0.0);
  }
  rivals.OnRegistered({.translation_m = {3.0, 0.0}}, -0.1);
  EXPECT_NE(NextToRegister_m(rivals), 3.0) << "it waits for the next scan";
}

// Scans fit a rival 3 m ahead; registrations put it `shift_m` from there, with such a lead.
bool IsBetterAfterRegistrations(int count, double shift_m, double score_lead) {
  AlongTrackRivalOptions options = SixPlaces(6);
  options.registrations_per_rival = 1;
  AlongTrackRivals rivals(options);
  for (int i = 0; i < count; ++i) {
    Compare(rivals, 0.4, 3.0, 0.46);
    rivals.CountToRegister();
    EXPECT_EQ(NextToRegister_m(rivals), 3.0);
    rivals.OnRegistered({.translation_m = {3.0 + shift_m, 0.3}}, score_lead);
  }
  return rivals.has_better();
}

TEST(AlongTrackRivalsTest, ARivalThatLeadsByRegistrationsIsBetter) {
  EXPECT_FALSE(IsBetterAfterRegistrations(1, 0.0, 0.5)) << "one alone does not decide";
  EXPECT_TRUE(IsBetterAfterRegistrations(3, 0.0, 0.08));
  EXPECT_FALSE(IsBetterAfterRegistrations(10, 0.0, 0.01));
  EXPECT_FALSE(IsBetterAfterRegistrations(10, -3.0, 0.5)) << "it ended at the pose";
}

TEST(AlongTrackRivalsTest, ARivalThatLeadsNoMoreIsNotBetterAnyMore) {
  AlongTrackRivals rivals(SixPlaces(6));
  const auto register_with = [&](double score_lead) {
    Compare(rivals, 0.4, 3.0, 0.46);
    EXPECT_EQ(NextToRegister_m(rivals), 3.0);
    rivals.OnRegistered({.translation_m = {3.0, 0.0}}, score_lead);
  };
  for (int i = 0; i < 3; ++i) register_with(0.1);
  EXPECT_TRUE(rivals.has_better());
  for (int i = 0; i < 2; ++i) register_with(-0.1);
  EXPECT_FALSE(rivals.has_better());
}

// Whether the pose stands out after so many rivals, each registered with this lead.
bool StandsOutAfter(int count, double score_lead) {
  AlongTrackRivals rivals(SixPlaces(6));
  for (int i = 0; i < count; ++i) {
    Compare(rivals, 0.5, 3.0, 0.4);
    EXPECT_GE(rivals.CountToRegister(), 1);
    EXPECT_EQ(NextToRegister_m(rivals), 3.0);
    rivals.OnRegistered({.translation_m = {3.0, 0.0}}, score_lead);
  }
  return rivals.stands_out();
}

TEST(AlongTrackRivalsTest, APoseStandsOutThatBeatsItsRivals) {
  EXPECT_FALSE(StandsOutAfter(2, -0.1));
  EXPECT_TRUE(StandsOutAfter(3, -0.1));
  EXPECT_FALSE(StandsOutAfter(30, 0.0));
  EXPECT_FALSE(StandsOutAfter(30, -0.02)) << "by little";
}

TEST(AlongTrackRivalsTest, ThePoseMustBeatTheBestOfAllPlaces) {
  AlongTrackRivals rivals(SixPlaces(3));
  const auto compare_all = [&] {
    Compare(rivals, 0.5, 3.0, 0.4);
    EXPECT_EQ(rivals.CountToRegister(), 0) << "half of them were compared";
    Compare(rivals, 0.5, 3.0, 0.4);
    EXPECT_EQ(rivals.CountToRegister(), 3);
    EXPECT_EQ(NextToRegister_m(rivals), 3.0);
  };
  compare_all();
  rivals.OnRegistered({.translation_m = {3.0, 0.0}}, 0.0);
  EXPECT_FALSE(rivals.NextToRegister()) << "one was not beaten";
  compare_all();
}

TEST(AlongTrackRivalsTest, PlacesBesideARegisteredRivalAreNotRegistered) {
  AlongTrackRivals rivals(SixPlaces(6));
  Compare(rivals, 0.5, 3.0, 0.4);
  EXPECT_EQ(NextToRegister_m(rivals), 3.0);
  rivals.OnRegistered({.translation_m = {3.0, 0.0}}, -0.1);
  EXPECT_LT(NextToRegister_m(rivals), 0.0);
}

TEST(AlongTrackRivalsTest, ARivalThatEndsAtThePoseIsBeatenOneThatEndsElsewhereIsNot) {
  AlongTrackRivals rivals(SixPlaces(6));
  const auto stands_out_by_ends = [&](double end_m) {
    rivals.OnPlaceFound();
    for (int i = 0; i < 3; ++i) {
      Compare(rivals, 0.5, 3.0, 0.4);
      EXPECT_EQ(NextToRegister_m(rivals), 3.0);
      rivals.OnRegistered({.translation_m = {end_m, 0.0}}, 0.0);
    }
    return rivals.stands_out();
  };
  EXPECT_TRUE(stands_out_by_ends(0.1));
  EXPECT_FALSE(stands_out_by_ends(6.0));
}

TEST(AlongTrackRivalsTest, APlaceThatIsFoundMustStandOutAnew) {
  AlongTrackRivals rivals(SixPlaces(6));
  rivals.SupposeThatItStandsOut();
  rivals.Reset();
  EXPECT_TRUE(rivals.stands_out());
  rivals.OnPlaceFound();
  EXPECT_FALSE(rivals.stands_out());
}

TEST(AlongTrackRivalsTest, WhereScansCannotBeComparedAPoseNeedNotStandOut) {
  AlongTrackRivals rivals({.max_wait_count = 4});
  for (int i = 0; i < 4; ++i) rivals.CountToRegister();
  EXPECT_FALSE(rivals.stands_out());
  rivals.CountToRegister();
  EXPECT_TRUE(rivals.stands_out());
  EXPECT_TRUE(AlongTrackRivals({.max_offset_m = 0.0}).stands_out()) << "no rivals";
}

TEST(AlongTrackRivalsTest, WithoutADistanceThereAreNone) {
  AlongTrackRivals rivals({.max_offset_m = 0.0});
  EXPECT_TRUE(rivals.NextPlaces(0.0).empty());
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
  AlongTrackRivals rivals(SixPlaces(3));
  rivals.NextPlaces(0.0);
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
