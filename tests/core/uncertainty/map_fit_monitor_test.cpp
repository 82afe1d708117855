#include "core/uncertainty/map_fit_monitor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

namespace dcloc {
namespace {

using ::testing::AllOf;
using ::testing::Ge;
using ::testing::Le;

constexpr std::size_t kPoints = 50;

MapFitMonitor Learned(double mean, double sigma, int count = 200) {
  MapFitMonitor monitor(2, {});
  std::mt19937 random(1);
  std::normal_distribution<double> fit(mean, sigma);
  for (int i = 0; i < count; ++i) monitor.Learn(0, kPoints, fit(random));
  return monitor;
}

TEST(MapFitMonitorTest, NothingIsExpectedBeforeScansHaveBeenSeen) {
  EXPECT_EQ(Learned(0.6, 0.05, 5).Judge(0, kPoints, 0.0), ScanFit::kUnknown);
  EXPECT_EQ(Learned(0.6, 0.05).Judge(1, kPoints, 0.0), ScanFit::kUnknown) << "another radar";
  EXPECT_EQ(Learned(0.6, 0.05).Judge(0, 3, 0.0), ScanFit::kUnknown) << "of three points";
}

TEST(MapFitMonitorTest, AScanOfAnotherPlaceContradicts) {
  const MapFitMonitor monitor = Learned(0.6, 0.05);
  EXPECT_EQ(monitor.Judge(0, kPoints, 0.6), ScanFit::kAgrees);
  EXPECT_EQ(monitor.Judge(0, kPoints, 0.45), ScanFit::kAgrees);
  EXPECT_EQ(monitor.Judge(0, kPoints, 0.15), ScanFit::kContradicts);
}

TEST(MapFitMonitorTest, UsualScansSeldomContradict) {
  const MapFitMonitor monitor = Learned(0.6, 0.08);
  std::mt19937 random(2);
  std::normal_distribution<double> fit(0.6, 0.08);
  int contradictions = 0;
  for (int i = 0; i < 100'000; ++i) {
    if (monitor.Judge(0, kPoints, fit(random)) == ScanFit::kContradicts) ++contradictions;
  }
  EXPECT_LT(contradictions, 100);
}

TEST(MapFitMonitorTest, WhereScansFitLittleALittleLessSaysNothing) {
  EXPECT_EQ(Learned(0.2, 0.08).Judge(0, kPoints, 0.02), ScanFit::kAgrees);
}

TEST(MapFitMonitorTest, ScansThatAllFitALittleLessAreADecline) {
  MapFitMonitor monitor = Learned(0.5, 0.04);
  const auto scans_until = [&monitor](bool declined, double fit) {
    int scans = 0;
    while ((monitor.Trend() == FitTrend::kDeclined) != declined && scans < 100) {
      monitor.Follow(0, kPoints, fit);
      ++scans;
    }
    return scans;
  };
  EXPECT_THAT(scans_until(true, 0.37), AllOf(Ge(4), Le(12))) << "one alone says little";
  EXPECT_EQ(monitor.Judge(0, kPoints, 0.37), ScanFit::kAgrees) << "each one alone agrees";
  for (int i = 0; i < 1000; ++i) monitor.Follow(0, kPoints, 0.37);
  EXPECT_EQ(monitor.Trend(), FitTrend::kDeclined);
  EXPECT_LE(scans_until(false, 0.5), 12) << "scans that fit as before";
}

// What is learned meanwhile would make a wrong place the expected one before it is found out.
TEST(MapFitMonitorTest, ADeclineIsFoundWhileScansAreLearned) {
  MapFitMonitor monitor = Learned(0.57, 0.045);
  std::mt19937 random(5);
  std::normal_distribution<double> elsewhere(0.42, 0.045);
  int scans_until_declined = 0;
  for (int scan = 1; scan <= 200; ++scan) {
    const double fit = elsewhere(random);
    monitor.Follow(0, kPoints, fit);
    if (monitor.Trend() == FitTrend::kDeclined) {
      if (scans_until_declined == 0) scans_until_declined = scan;
    } else {
      EXPECT_EQ(scans_until_declined, 0) << "and it lasts, scan " << scan;
      monitor.Learn(0, kPoints, fit);
    }
  }
  EXPECT_THAT(scans_until_declined, AllOf(Ge(4), Le(20)));
}

TEST(MapFitMonitorTest, FitsThatChangeSlowlyAreFollowed) {
  MapFitMonitor monitor = Learned(0.6, 0.045);
  std::mt19937 random(6);
  std::normal_distribution<double> noise(0.0, 0.045);
  for (int scan = 0; scan < 500; ++scan) {
    const double fit = 0.6 - 0.25 * scan / 500.0 + noise(random);
    monitor.Follow(0, kPoints, fit);
    ASSERT_NE(monitor.Trend(), FitTrend::kDeclined) << "scan " << scan;
    monitor.Learn(0, kPoints, fit);
  }
  EXPECT_EQ(monitor.Judge(0, kPoints, 0.3), ScanFit::kAgrees);
}

TEST(MapFitMonitorTest, UsualScansSeldomDecline) {
  MapFitMonitor monitor = Learned(0.5, 0.06);
  std::mt19937 random(4);
  std::normal_distribution<double> fit(0.5, 0.06);
  int declines = 0;
  for (int i = 0; i < 100'000; ++i) {
    monitor.Follow(0, kPoints, fit(random));
    declines += monitor.Trend() == FitTrend::kDeclined ? 1 : 0;
  }
  EXPECT_EQ(declines, 0);
  for (int i = 0; i < 100; ++i) monitor.Follow(1, kPoints, 0.0);
  EXPECT_EQ(monitor.Trend(), FitTrend::kUsual) << "nothing is known of this radar";
}

TEST(MapFitMonitorTest, ForgottenIsUnknown) {
  MapFitMonitor monitor = Learned(0.6, 0.05);
  monitor.Reset();
  EXPECT_EQ(monitor.Judge(0, kPoints, 0.0), ScanFit::kUnknown);
}

}  // namespace
}  // namespace dcloc
