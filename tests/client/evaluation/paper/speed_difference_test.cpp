#include "client/evaluation/paper/speed_difference.h"

#include <gtest/gtest.h>

#include <functional>

#include "tests/client/evaluation/paper/made_outcomes.h"

namespace dcloc::paper {
namespace {

// Scans every 50 ms along x, `x_m` of the seconds since the start.
Drive Along(double begin_s, double duration_s, const std::function<double(double)>& x_m,
            double y_m = 0.0) {
  Drive drive;
  constexpr double kInterval_s = 0.05;
  for (int scan = 0; scan * kInterval_s < duration_s; ++scan) {
    const double t = scan * kInterval_s;
    DriveScan entry;
    entry.scan.stamp = At(begin_s + t);
    entry.T_map_vehicle.translation_m = {x_m(t), y_m, 0.0};
    drive.scans.push_back(entry);
  }
  return drive;
}

TEST(SpeedDifferences, AreOfTheLiveDriveAgainstTheMapDrive) {
  const Drive map = Along(0.0, 10.0, [](double t) { return 20.0 * t; });
  const Drive live = Along(
      100.0, 15.0, [](double t) { return 12.0 * t; }, 3.0);
  const SpeedDifferences differences(map, live);
  for (const DriveScan& entry : live.scans) {
    const auto difference = differences.At(entry.scan.stamp);
    ASSERT_TRUE(difference.has_value());
    EXPECT_NEAR(*difference, -8.0, 1e-6);
  }
}

// 10 m/s on the first 50 m and 20 m/s after them: what counts is the place, not the time.
TEST(SpeedDifferences, TakeTheMapDrivesSpeedAtTheNearestPlace) {
  const Drive map = Along(0.0, 10.0, [](double t) { return t < 5.0 ? 10.0 * t : 20.0 * t - 50.0; });
  const Drive live = Along(0.0, 8.0, [](double t) { return 15.0 * t; });
  const SpeedDifferences differences(map, live);
  EXPECT_NEAR(*differences.At(live.scans[40].scan.stamp), 5.0, 1e-6);    // at 30 m
  EXPECT_NEAR(*differences.At(live.scans[120].scan.stamp), -5.0, 1e-6);  // at 90 m
}

TEST(SpeedDifferences, KnowNothingOfOtherMoments) {
  const Drive drive = Along(0.0, 2.0, [](double t) { return t; });
  const SpeedDifferences differences(drive, drive);
  EXPECT_FALSE(differences.At(At(0.01)).has_value());
  EXPECT_FALSE(differences.At(At(50.0)).has_value());
  const SpeedDifferences without_map(Drive{}, drive);
  EXPECT_FALSE(without_map.At(drive.scans[0].scan.stamp).has_value());
}

TEST(SpeedDifferences, AreZeroForOneWhoStandsWhereAnotherStood) {
  const Drive map = Along(0.0, 3.0, [](double) { return 5.0; });
  Drive live = Along(50.0, 0.06, [](double) { return 5.0; });
  live.scans.resize(1);  // a speed of one scan
  EXPECT_EQ(SpeedDifferences(map, live).At(live.scans[0].scan.stamp), 0.0);
}

}  // namespace
}  // namespace dcloc::paper
