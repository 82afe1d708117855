#include "client/evaluation/paper/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/client/evaluation/paper/made_outcomes.h"

namespace dcloc::paper {
namespace {

TEST(CommonSuccesses, KeepsTheScansAtWhichAllWereRight) {
  const DriveOutcome a = WithErrors({0.1, 0.2, 3.0, 0.4});
  DriveOutcome b = WithErrors({0.5, 2.5, 0.7, 0.8});
  b.scans.push_back(MadeScan(9.0, 0.1, 0.1));  // the other one gave no answer then
  const DriveOutcome* both[] = {&a, &b};
  const auto common = CommonSuccesses(both);
  ASSERT_EQ(common.size(), 2U);
  ASSERT_EQ(common[0].scans.size(), 2U);
  ASSERT_EQ(common[1].scans.size(), 2U);
  EXPECT_EQ(common[0].scans[1].error.translation_m, 0.4);
  EXPECT_EQ(common[1].scans[0].error.translation_m, 0.5);
  EXPECT_EQ(common[1].scans[1].error.translation_m, 0.8);
}

TEST(CommonSuccesses, TellsRadarsOfOneMomentApart) {
  DriveOutcome a = WithErrors({0.1});
  DriveOutcome b = WithErrors({0.1});
  b.scans[0].radar_id = "rear";
  const DriveOutcome* both[] = {&a, &b};
  EXPECT_TRUE(CommonSuccesses(both)[0].scans.empty());
}

TEST(CommonSuccesses, CountsAnUnansweredScanAsAFailure) {
  DriveOutcome a = WithErrors({0.1, 0.1});
  a.scans[0].answer.state = LocalizationState::kInitializing;
  const DriveOutcome b = WithErrors({0.1, 0.1});
  const DriveOutcome* both[] = {&a, &b};
  EXPECT_EQ(CommonSuccesses(both)[1].scans.size(), 1U);
}

TEST(ErrorSlope, IsThatOfALine) {
  DriveOutcome outcome = MadeOutcome({});
  for (int i = 0; i < 60; ++i) {
    const double difference_mps = -12.0 + 0.4 * i;
    outcome.scans.push_back(
        MadeScan(i, 0.1 + 0.02 * std::abs(difference_mps), 0.1, difference_mps));
  }
  outcome.scans.push_back(MadeScan(61, 50.0, 0.1, 12.0));  // a failure is no error to be averaged
  outcome.scans.push_back(MadeScan(62, 1.0, 0.1));         // nobody knows its speed difference
  const Slope slope = ErrorSlope({&outcome, 1});
  EXPECT_NEAR(slope.m_per_mps, 0.02, 1e-12);
  EXPECT_NEAR(slope.low, 0.02, 1e-9);
  EXPECT_NEAR(slope.high, 0.02, 1e-9);
  EXPECT_EQ(slope.answer_count, 60U);
}

// Errors that stay the same for five seconds: an interval that took scans for independent would
// miss the truth most of the time.
TEST(ErrorSlope, HasAnIntervalThatHoldsTheTruthWithCorrelatedErrors) {
  constexpr double kSlope = 0.003;
  constexpr int kTrials = 400;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> speed_mps(0.0, 12.0);
  std::normal_distribution<double> shared_m(0.0, 0.02);
  int held = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    DriveOutcome outcome = MadeOutcome({});
    for (int stretch = 0; stretch < 20; ++stretch) {
      const double difference_mps = speed_mps(random);
      const double error_m = 0.2 + kSlope * difference_mps + shared_m(random);
      for (int i = 0; i < 20; ++i) {
        outcome.scans.push_back(MadeScan(5.0 * stretch + 0.2 * i, error_m, 0.1, difference_mps));
      }
    }
    const Slope slope = ErrorSlope({&outcome, 1});
    if (slope.low <= kSlope && kSlope <= slope.high) ++held;
  }
  EXPECT_GT(held, kTrials * 88 / 100);
  EXPECT_LT(held, kTrials * 99 / 100);
}

TEST(ErrorSlope, IsNotDeterminedByOneSpeedNorByAFewSeconds) {
  DriveOutcome one_speed = MadeOutcome({});
  DriveOutcome short_one = MadeOutcome({});
  for (int i = 0; i < 100; ++i) {
    one_speed.scans.push_back(MadeScan(i, 0.1 + 0.001 * i, 0.1, 8.0));
    short_one.scans.push_back(MadeScan(0.1 * i, 0.1, 0.1, 0.1 * i));
  }
  EXPECT_TRUE(std::isnan(ErrorSlope({&one_speed, 1}).m_per_mps));
  EXPECT_TRUE(std::isnan(ErrorSlope({&short_one, 1}).low));
  EXPECT_TRUE(std::isnan(ErrorSlope({}).high));
}

TEST(ErrorsBySpeedDifference, BinsRightAnswersByTheAbsoluteDifference) {
  DriveOutcome outcome = MadeOutcome({MadeScan(0, 0.1, 1.0, 0.5), MadeScan(1, 0.3, 3.0, -1.5),
                                      MadeScan(2, 0.8, 2.0, 1.9), MadeScan(3, 9.0, 0.1, 1.0),
                                      MadeScan(4, 0.5, 0.2, -6.0), MadeScan(5, 0.7, 0.4, 7.9),
                                      MadeScan(6, 0.5, 0.5, 3.0), MadeScan(7, 0.5, 0.5)});
  const auto bins = ErrorsBySpeedDifference({&outcome, 1}, 2);
  ASSERT_EQ(bins.size(), 2U);  // between 2 and 4 m/s there is but one
  EXPECT_EQ(bins[0].begin_mps, 0.0);
  EXPECT_EQ(bins[0].end_mps, 2.0);
  EXPECT_EQ(bins[0].count, 3U);
  EXPECT_NEAR(bins[0].rte_mean_m, 0.4, 1e-12);
  EXPECT_NEAR(bins[0].rte_median_m, 0.3, 1e-12);
  EXPECT_NEAR(bins[0].rre_mean_deg, 2.0, 1e-12);
  EXPECT_NEAR(bins[0].rre_median_deg, 2.0, 1e-12);
  EXPECT_EQ(bins[1].begin_mps, 6.0);
  EXPECT_EQ(bins[1].count, 2U);
  EXPECT_NEAR(bins[1].rte_mean_m, 0.6, 1e-12);
}

}  // namespace
}  // namespace dcloc::paper
