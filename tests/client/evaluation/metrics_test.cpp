#include "client/evaluation/metrics.h"

#include <gtest/gtest.h>

#include <cmath>

#include "client/evaluation/metrics_format.h"

namespace dcloc {
namespace {

ScanOutcome Scan(LocalizationState state, double translation_m, double rotation_deg, double nees) {
  ScanOutcome scan;
  scan.answer.state = state;
  scan.error.translation_m = translation_m;
  scan.error.rotation_deg = rotation_deg;
  scan.error.nees = nees;
  scan.error.dof = 3;
  scan.total_ms = 2.0;
  return scan;
}

DriveOutcome Outcome() {
  DriveOutcome outcome;
  outcome.drive = "town";
  outcome.refused_count = 2;
  outcome.scans = {Scan(LocalizationState::kInitializing, 90.0, 90.0, 1e6),
                   Scan(LocalizationState::kTracking, 1.0, 1.0, 3.0),
                   Scan(LocalizationState::kTracking, 2.5, 1.0, 6.0),   // honest: it says so
                   Scan(LocalizationState::kTracking, 3.0, 1.0, 30.0),  // misleading
                   Scan(LocalizationState::kTracking, 0.5, 7.0, 12.0),  // between 95 and 99.9 %
                   Scan(LocalizationState::kDeadReckoning, 4.0, 1.0, 90.0),
                   Scan(LocalizationState::kLost, 0.0, 0.0, 0.0)};
  outcome.scans[1].stage_ms[0] = 1.0;
  outcome.scans[2].stage_ms[0] = 3.0;
  outcome.scans[2].total_ms = 8.0;
  return outcome;
}

TEST(Quantile, IsLinearBetweenRanks) {
  EXPECT_DOUBLE_EQ(Quantile({4.0, 1.0, 3.0, 2.0}, 0.5), 2.5);
  EXPECT_DOUBLE_EQ(Quantile({4.0, 1.0, 3.0, 2.0}, 1.0), 4.0);
  EXPECT_DOUBLE_EQ(Quantile({4.0, 1.0, 3.0, 2.0}, 0.0), 1.0);
  EXPECT_DOUBLE_EQ(Quantile({1.0, 2.0}, 0.95), 1.95);
  EXPECT_TRUE(std::isnan(Quantile({}, 0.5)));
}

TEST(ComputeMetrics, JudgesAnsweredScansOnly) {
  const DriveOutcome outcome = Outcome();
  const Metrics metrics = ComputeMetrics({&outcome, 1});
  EXPECT_EQ(metrics.scan_count, 7U);
  EXPECT_EQ(metrics.answered_count, 6U);
  EXPECT_EQ(metrics.refused_count, 2U);
  EXPECT_DOUBLE_EQ(metrics.rte_m.mean, 11.0 / 6.0);
  EXPECT_DOUBLE_EQ(metrics.rte_m.median, 1.75);
  EXPECT_DOUBLE_EQ(metrics.rte_m.max, 4.0);
  EXPECT_DOUBLE_EQ(metrics.rte_m.rms, std::sqrt((1.0 + 6.25 + 9.0 + 0.25 + 16.0) / 6.0));
  EXPECT_DOUBLE_EQ(metrics.rre_deg.max, 7.0);
}

TEST(ComputeMetrics, CountsSuccessCoverageAndMisleadingAnswers) {
  const DriveOutcome outcome = Outcome();
  const Metrics metrics = ComputeMetrics({&outcome, 1});
  EXPECT_DOUBLE_EQ(metrics.success_rate, 2.0 / 6.0);
  EXPECT_DOUBLE_EQ(metrics.success_rate_all, 2.0 / 7.0);
  EXPECT_DOUBLE_EQ(metrics.anees, (3.0 + 6.0 + 30.0 + 12.0 + 90.0) / 3.0 / 6.0);
  EXPECT_DOUBLE_EQ(metrics.coverage_95, 3.0 / 6.0);
  EXPECT_DOUBLE_EQ(metrics.coverage_999, 4.0 / 6.0);
  EXPECT_EQ(metrics.misleading_count,
            1U);  // dead reckoning that is wrong does not call itself right
  EXPECT_EQ(metrics.state_counts, (std::array<std::size_t, 4>{1, 4, 1, 1}));
}

TEST(ComputeMetrics, SummarizesTimesOfStagesThatRan) {
  const DriveOutcome outcome = Outcome();
  const Metrics metrics = ComputeMetrics({&outcome, 1});
  EXPECT_DOUBLE_EQ(metrics.stage_ms[0].p50, 2.0);
  EXPECT_TRUE(std::isnan(metrics.stage_ms[1].p50));
  EXPECT_DOUBLE_EQ(metrics.total_ms.p50, 2.0);
  EXPECT_NEAR(metrics.total_ms.p99, 8.0, 0.4);
}

TEST(ComputeMetrics, PoolsTheScansOfAllDrives) {
  const std::vector<DriveOutcome> outcomes = {Outcome(), Outcome()};
  const Metrics metrics = ComputeMetrics(outcomes);
  EXPECT_EQ(metrics.scan_count, 14U);
  EXPECT_EQ(metrics.refused_count, 4U);
  EXPECT_EQ(metrics.misleading_count, 2U);
  EXPECT_DOUBLE_EQ(metrics.rte_m.mean, 11.0 / 6.0);
}

TEST(MetricsJson, HasTheNamesThatScriptsReadAndNoNan) {
  const DriveOutcome outcome = Outcome();
  const auto json = MetricsJson(ComputeMetrics({&outcome, 1}));
  EXPECT_DOUBLE_EQ(json["rte_m"]["median"].get<double>(), 1.75);
  EXPECT_DOUBLE_EQ(json["rre_deg"]["max"].get<double>(), 7.0);
  EXPECT_EQ(json["misleading_count"], 1);
  EXPECT_EQ(json["scans"], 7);
  EXPECT_EQ(json["states"]["INITIALIZING"], 1);
  EXPECT_EQ(json["states"]["TRACKING"], 4);
  EXPECT_EQ(json["states"]["DEAD_RECKONING"], 1);
  EXPECT_EQ(json["states"]["LOST"], 1);
  EXPECT_DOUBLE_EQ(json["stage_ms"]["compensation"]["p50"].get<double>(), 2.0);
  EXPECT_TRUE(json["stage_ms"]["submap"]["p50"].is_null());
  EXPECT_DOUBLE_EQ(json["stage_ms"]["total"]["p50"].get<double>(), 2.0);
  for (const char* key : {"success_rate", "anees", "coverage_95", "coverage_999"}) {
    EXPECT_TRUE(json[key].is_number()) << key;
  }
}

TEST(MetricsJson, IsNullWhereNothingWasAnswered) {
  const auto json = MetricsJson(ComputeMetrics({}));
  EXPECT_TRUE(json["rte_m"]["mean"].is_null());
  EXPECT_TRUE(json["success_rate"].is_null());
  EXPECT_TRUE(json["anees"].is_null());
  EXPECT_EQ(json["scans"], 0);
}

TEST(ScansCsv, HasALineOfEqualLengthForEachScan) {
  const std::string csv = ScansCsv({Outcome()});
  std::vector<std::ptrdiff_t> commas;
  for (std::size_t begin = 0; begin < csv.size();) {
    const std::size_t end = csv.find('\n', begin);
    ASSERT_NE(end, std::string::npos);
    commas.push_back(std::count(csv.begin() + static_cast<std::ptrdiff_t>(begin),
                                csv.begin() + static_cast<std::ptrdiff_t>(end), ','));
    begin = end + 1;
  }
  ASSERT_EQ(commas.size(), 8U);
  for (const std::ptrdiff_t count : commas) EXPECT_EQ(count, commas.front());
}

}  // namespace
}  // namespace dcloc
