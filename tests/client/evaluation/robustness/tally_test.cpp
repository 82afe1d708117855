#include "client/evaluation/robustness/tally.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace dcloc::robustness {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Tally Some() {
  Tally tally;
  tally.scans = 10;
  tally.right = 7;
  tally.flagged = 2;
  tally.wrong = 1;
  tally.worst_tracking_m = 3.5;
  tally.nees_per_dof_sum = 9.0;
  tally.nees_count = 9;
  tally.episodes = 2;
  tally.recovery_s = {1.5};
  tally.right_claim_s = {0.5, 2.0};
  tally.Add({.what = "wrong", .drive = "live-0", .error_m = 3.5, .nees = kInfinity});
  return tally;
}

TEST(TallyTest, TwoTalliesAreOneOfTheSums) {
  Tally tally = Some();
  Tally other = Some();
  other.worst_tracking_m = 1.0;
  Merge(other, tally);
  EXPECT_EQ(tally.scans, 20U);
  EXPECT_EQ(tally.wrong, 2U);
  EXPECT_EQ(tally.episodes, 4U);
  EXPECT_EQ(tally.worst_tracking_m, 3.5);
  EXPECT_EQ(tally.nees_per_dof_sum, 18.0);
  EXPECT_EQ(tally.right_claim_s.size(), 4U);
  EXPECT_EQ(tally.incidents.size(), 2U);
}

TEST(TallyTest, IncidentsAreBounded) {
  Tally tally;
  for (std::size_t i = 0; i < 2 * Tally::kMaxIncidents; ++i) tally.Add({});
  EXPECT_EQ(tally.incidents.size(), Tally::kMaxIncidents);
}

TEST(TallyTest, WhatNeverCameCountsAsInfinitelyLate) {
  const std::vector<double> values = {3.0, 1.0, 2.0};
  EXPECT_EQ(QuantileOf(values, 3, 0.5), 2.0);
  EXPECT_EQ(QuantileOf(values, 4, 0.5), 2.0);
  EXPECT_EQ(QuantileOf(values, 4, 1.0), kInfinity);
  EXPECT_EQ(QuantileOf(values, 3, 0.0), 1.0);
  EXPECT_TRUE(std::isnan(QuantileOf({}, 0, 0.5)));
  EXPECT_EQ(ShareWithin(values, 4, 2.0), 0.5);
  EXPECT_TRUE(std::isnan(ShareWithin({}, 0, 2.0)));
}

TEST(TallyTest, ATallyComesBackFromJsonWithItsInfinities) {
  const nlohmann::ordered_json json = TallyToJson(Some());
  const auto back = TallyFromJson(nlohmann::json::parse(json.dump()));
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(TallyToJson(*back), json);
  ASSERT_EQ(back->incidents.size(), 1U);
  EXPECT_EQ(back->incidents[0].nees, kInfinity);
}

TEST(TallyTest, JsonOfAnotherShapeIsNoTally) {
  nlohmann::json json = nlohmann::json::parse(TallyToJson(Some()).dump());
  EXPECT_FALSE(TallyFromJson(nlohmann::json::array()).has_value());
  json["wrong"] = "none";
  EXPECT_FALSE(TallyFromJson(json).has_value());
  json.erase("wrong");
  EXPECT_FALSE(TallyFromJson(json).has_value());
}

}  // namespace
}  // namespace dcloc::robustness
