#include "core/update/presence.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/update/presence_fit.h"

namespace dcloc {
namespace {

/// A pass a day, `base_age_days` after the base map.
std::vector<PassEvidence> Passes(double expected_hits, const std::vector<int>& hits,
                                 double base_age_days = 30.0, double days_between = 1.0,
                                 double position_ratio = 3.0) {
  std::vector<PassEvidence> passes;
  for (const int count : hits) {
    passes.push_back({expected_hits, count, count > 0 ? position_ratio : 1.0,
                      passes.empty() ? base_age_days : days_between});
  }
  return passes;
}

double Total(const Presence& presence) {
  return presence.stays + presence.added + presence.removed + presence.intermittent +
         presence.never;
}

TEST(PresenceTest, WhatIsSeenInEachPassStays) {
  const Presence presence = PosteriorOfMapLandmark(Passes(8.0, {7, 9, 5}), {});
  EXPECT_GT(presence.stays, 0.95);
  EXPECT_NEAR(Total(presence), 1.0, 1e-9);
}

TEST(PresenceTest, WhatWasInViewAndNeverSeenWent) {
  const Presence presence = PosteriorOfMapLandmark(Passes(12.0, {0, 0, 0, 0, 0}), {});
  EXPECT_GT(presence.removed, 0.9);
  EXPECT_EQ(presence.since, 0U);
}

TEST(PresenceTest, WhatWasNotInViewTellsNothing) {
  const PresenceModel model;
  const Presence presence = PosteriorOfMapLandmark(Passes(0.0, {0, 0, 0}), model);
  EXPECT_NEAR(presence.intermittent, model.known_intermittent, 1e-9);
  const double lasts = 1.0 - model.known_removed - model.known_intermittent;
  EXPECT_NEAR(presence.stays, lasts * std::exp(-2.0 * model.changes_per_day), 1e-9);
  // A hit of what cannot be seen is false, and says nothing either.
  EXPECT_NEAR(PosteriorOfMapLandmark(Passes(0.0, {0, 4, 0}), model).stays, presence.stays, 1e-9);
}

TEST(PresenceTest, AMissOrTwoOfWhatIsHardToSeeIsNoAbsence) {
  EXPECT_GT(PosteriorOfMapLandmark(Passes(1.0, {0, 2, 0}), {}).stays, 0.5);
}

TEST(PresenceTest, WhatIsThereOneDayAndNotTheNextComesAndGoes) {
  constexpr double kElsewhere = 0.5;  // another vehicle stands a little differently
  const Presence known =
      PosteriorOfMapLandmark(Passes(15.0, {12, 0, 14, 0, 13}, 30.0, 1.0, kElsewhere), {});
  EXPECT_GT(known.intermittent, 0.9);
  const Presence found =
      PosteriorOfCandidate(Passes(15.0, {0, 12, 0, 14}, 30.0, 1.0, kElsewhere), {});
  EXPECT_GT(found.intermittent, 0.9);
}

TEST(PresenceTest, WhatIsSeenFromSomePassOnCame) {
  const Presence from_first = PosteriorOfCandidate(Passes(8.0, {7, 9, 6}), {});
  EXPECT_GT(from_first.added, 0.5);
  EXPECT_EQ(from_first.since, 0U);
  EXPECT_EQ(PosteriorOfCandidate(Passes(8.0, {0, 9, 6, 8}), {}).since, 1U);
}

TEST(PresenceTest, WhereACandidateIsItsBestSightingSays) {
  std::vector<PassEvidence> passes = Passes(8.0, {7, 9, 6}, 30.0, 1.0, 0.8);
  const double before = PosteriorOfCandidate(passes, {}).added;
  passes[1].position_ratio = 1.0;
  const double apart = PosteriorOfCandidate(passes, {}).added;
  EXPECT_GT(apart, before);
  passes[1].position_ratio = 4.0;
  EXPECT_NEAR(PosteriorOfCandidate(passes, {}).added, apart, 1e-12);
  // A second one that lies there speaks for it.
  passes[2].position_ratio = 4.0;
  EXPECT_GT(PosteriorOfCandidate(passes, {}).added, apart);
}

TEST(PresenceTest, WhatIsSeenTwiceIsWhatIsExpectedThere) {
  const std::vector<PassEvidence> passes = Passes(15.0, {12, 0, 14}, 30.0, 1.0, 1.0);
  const PresenceModel model;
  EXPECT_GT(PosteriorOfMapLandmark(passes, WithIntermittent(model, 0.9)).intermittent, 0.9);
  EXPECT_LT(PosteriorOfMapLandmark(passes, WithIntermittent(model, 0.01)).intermittent, 0.5);
}

TEST(PresenceTest, OneSightingIsNotProof) {
  EXPECT_LT(PosteriorOfCandidate(Passes(8.0, {9, 0, 0}), {}).added, 0.1);
}

TEST(PresenceTest, SurvivalIsByTimeAndNotByPasses) {
  const std::vector<int> hits = {9, 9, 0, 0};
  const double within_hours = PosteriorOfMapLandmark(Passes(4.0, hits, 30.0, 0.1), {}).removed;
  const double within_months = PosteriorOfMapLandmark(Passes(4.0, hits, 30.0, 100.0), {}).removed;
  EXPECT_GT(within_months, 2.0 * within_hours);
}

TEST(PresenceTest, AHundredPassesAreNoTrouble) {
  EXPECT_GT(PosteriorOfMapLandmark(Passes(12.0, std::vector<int>(100, 40)), {}).stays, 0.99);
  EXPECT_GT(PosteriorOfCandidate(Passes(12.0, std::vector<int>(100, 40)), {}).added, 0.99);
}

TEST(PresenceFitTest, LearnsHowMuchWent) {
  std::vector<std::vector<PassEvidence>> known(160, Passes(12.0, {11, 13, 12}));
  known.insert(known.end(), 40, Passes(12.0, {0, 0, 0}));
  const PresenceModel model = FitPresence(known, {}, {});
  EXPECT_NEAR(model.known_removed, 0.2, 0.03);
  EXPECT_GT(PosteriorOfMapLandmark(known.front(), model).stays, 0.95);
}

}  // namespace
}  // namespace dcloc
