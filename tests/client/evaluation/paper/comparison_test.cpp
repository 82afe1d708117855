#include "client/evaluation/paper/comparison.h"

#include <gtest/gtest.h>

#include "tests/client/evaluation/paper/made_outcomes.h"

namespace dcloc::paper {
namespace {

const Variant kOurs;
const Variant kIcpVariant = {.method = MethodKind::kIcp};
const Variant kDcLocVariant = {.method = MethodKind::kDcLoc};

std::vector<RowPlan> Plans() {
  return {{"ICP", kIcpVariant, {}}, {"DC-Loc", kDcLocVariant, {}}, {"ours", kOurs, {}}};
}

TEST(Compare, PrintsThePapersSelectionAndEverything) {
  const std::vector<RunResult> results = {
      MadeResult("town", "a", kIcpVariant, WithErrors({0.4, 5.0, 0.6})),
      MadeResult("town", "a", kOurs, WithErrors({0.1, 0.2, 0.3}))};
  const auto rows = Compare(results, "town", Protocol::kTrack, Plans());
  ASSERT_TRUE(rows.has_value());
  ASSERT_EQ(rows->size(), 2U);  // nobody ran DC-Loc
  EXPECT_EQ((*rows)[0].plan.label, "ICP");
  EXPECT_DOUBLE_EQ((*rows)[0].common.rte_m.mean, 0.5);
  EXPECT_DOUBLE_EQ((*rows)[0].all.rte_m.mean, 2.0);
  EXPECT_DOUBLE_EQ((*rows)[0].all.success_rate_all, 2.0 / 3.0);
  EXPECT_DOUBLE_EQ((*rows)[1].common.rte_m.mean, 0.2);
  EXPECT_EQ((*rows)[1].common.scan_count, 2U);
  EXPECT_EQ((*rows)[1].all.scan_count, 3U);
}

TEST(Compare, LeavesOutCasesThatSomeoneDidNotRun) {
  const std::vector<RunResult> results = {MadeResult("town", "a", kIcpVariant, WithErrors({0.4})),
                                          MadeResult("town", "a", kOurs, WithErrors({0.1})),
                                          MadeResult("town", "b", kOurs, WithErrors({1.9, 1.9}))};
  const auto rows = Compare(results, "town", Protocol::kTrack, Plans());
  ASSERT_TRUE(rows.has_value());
  EXPECT_EQ(rows->back().all.scan_count, 1U);
  EXPECT_DOUBLE_EQ(rows->back().all.rte_m.mean, 0.1);
}

TEST(Compare, IsNothingWithoutTwoRowsOfOneCase) {
  const std::vector<RunResult> one = {MadeResult("town", "a", kOurs, WithErrors({0.1}))};
  EXPECT_FALSE(Compare(one, "town", Protocol::kTrack, Plans()).has_value());
  const std::vector<RunResult> apart = {
      MadeResult("town", "a", kOurs, WithErrors({0.1})),
      MadeResult("town", "b", kIcpVariant, WithErrors({0.1})),
      MadeResult("town", "a", kIcpVariant, WithErrors({0.1}), Protocol::kPairs)};
  EXPECT_FALSE(Compare(apart, "town", Protocol::kTrack, Plans()).has_value());
}

TEST(ResultsOf, JoinsAllSimulatedSetsUnderOneName) {
  const std::vector<RunResult> results = {MadeResult("simulated A", "a", kOurs, WithErrors({0.1})),
                                          MadeResult("simulated B", "b", kOurs, WithErrors({0.1})),
                                          MadeResult("noise gamma", "c", kOurs, WithErrors({0.1}))};
  EXPECT_EQ(ResultsOf(results, "simulated", kOurs, Protocol::kTrack).size(), 2U);
  EXPECT_EQ(ResultsOf(results, "simulated B", kOurs, Protocol::kTrack).size(), 1U);
  EXPECT_EQ(SetsOf(results),
            (std::vector<std::string>{"simulated A", "simulated B", "noise gamma"}));
}

}  // namespace
}  // namespace dcloc::paper
