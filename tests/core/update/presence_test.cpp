#include "core/update/presence.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/update/presence_fit.h"

namespace dcloc {
namespace {

std::vector<PassEvidence> Passes(double expected_hits, const std::vector<int>& hits,
                                 double days_before = 1.0) {
  std::vector<PassEvidence> passes;
  for (const int count : hits) passes.push_back({expected_hits, count, days_before});
  return passes;
}

double Total(const Presence& presence) {
  return presence.stays + presence.came + presence.went + presence.comes_and_goes + presence.never;
}

TEST(PresenceTest, WhatIsSeenInEachPassStays) {
  const Presence presence = JudgeKnown(Passes(8.0, {7, 9, 5}), {});
  EXPECT_GT(presence.stays, 0.95);
  EXPECT_NEAR(Total(presence), 1.0, 1e-9);
}

TEST(PresenceTest, WhatWasInViewAndNeverSeenWent) {
  const Presence presence = JudgeKnown(Passes(12.0, {0, 0, 0}), {.strength_shape = 2.0});
  EXPECT_GT(presence.went, 0.9);
  EXPECT_EQ(presence.since, 0U);
}

TEST(PresenceTest, WhatWasNotInViewTellsNothing) {
  const PresenceModel model;
  const Presence presence = JudgeKnown(Passes(0.0, {0, 0, 0}), model);
  // The intermittent part is by how likely the base map had seen it at all.
  EXPECT_NEAR(presence.stays / (presence.stays + presence.went), 1.0 - model.went_before, 0.01);
}

TEST(PresenceTest, AMissOrTwoOfWhatIsHardToSeeIsNoAbsence) {
  EXPECT_GT(JudgeKnown(Passes(1.0, {0, 2, 0}), {}).stays, 0.5);
}

TEST(PresenceTest, WhatIsThereOneDayAndNotTheNextComesAndGoes) {
  const Presence known = JudgeKnown(Passes(15.0, {12, 0, 14, 0, 13}), {.strength_shape = 4.0});
  EXPECT_GT(known.comes_and_goes, 0.9);
  const Presence found = JudgeNew(Passes(15.0, {0, 12, 0, 14}), {.strength_shape = 4.0});
  EXPECT_GT(found.comes_and_goes, 0.9);
}

TEST(PresenceTest, WhatIsSeenFromSomePassOnCame) {
  const Presence from_first = JudgeNew(Passes(8.0, {7, 9, 6}), {});
  EXPECT_GT(from_first.came, 0.5);
  EXPECT_EQ(from_first.since, 0U);
  EXPECT_EQ(JudgeNew(Passes(8.0, {0, 9, 6, 8}), {}).since, 1U);
}

TEST(PresenceTest, OneSightingIsNotProof) {
  EXPECT_LT(JudgeNew(Passes(8.0, {9, 0, 0}), {}).came, 0.1);
}

TEST(PresenceTest, SurvivalIsByTimeAndNotByPasses) {
  const auto hits = {9, 9, 0, 0};
  const double within_hours = JudgeKnown(Passes(4.0, hits, 0.1), {}).went;
  const double within_months = JudgeKnown(Passes(4.0, hits, 100.0), {}).went;
  EXPECT_GT(within_months, 2.0 * within_hours);
}

TEST(PresenceFitTest, LearnsTheShareThatWent) {
  std::vector<std::vector<PassEvidence>> known(160, Passes(12.0, {11, 13, 12}));
  known.insert(known.end(), 40, Passes(12.0, {0, 0, 0}));
  const PresenceModel model = FitPresence(known, {}, {.strength_shape = 2.0});
  EXPECT_NEAR(model.went_before, 0.2, 0.03);
  EXPECT_GT(JudgeKnown(known.front(), model).stays, 0.95);
}

}  // namespace
}  // namespace dcloc
