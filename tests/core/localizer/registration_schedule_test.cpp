#include "core/localizer/registration_schedule.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstddef>

namespace dcloc {
namespace {

using std::chrono::milliseconds;

Stamp ScanTime(int ms) { return Stamp(milliseconds(1'000'000 + ms)); }

constexpr int kFull = 10;
constexpr std::size_t kPoints = 50;  // of a scan

TEST(RegistrationScheduleTest, WaitsForAShareOfASubmapOrForTime) {
  RegistrationSchedule by_count({}, kFull);
  for (int scans = 1; scans <= kFull; ++scans) {
    by_count.OnScan(ScanTime(50 * scans), scans, kPoints);
    EXPECT_EQ(by_count.IsDue(false), scans >= 8) << scans;
  }
  RegistrationSchedule by_time({}, kFull);
  for (int scans = 1; scans <= 5; ++scans) {
    by_time.OnScan(ScanTime(300 * scans), scans, kPoints);
    EXPECT_EQ(by_time.IsDue(false), scans == 5) << scans;
  }
}

TEST(RegistrationScheduleTest, ASubmapThatBeginsAnewWaitsAgain) {
  RegistrationSchedule schedule({}, kFull);
  schedule.OnScan(ScanTime(0), kFull, kPoints);
  EXPECT_TRUE(schedule.IsDue(false));
  schedule.OnScan(ScanTime(5000), 1, kPoints);
  EXPECT_FALSE(schedule.IsDue(false));
}

TEST(RegistrationScheduleTest, ScansHaveComeSinceTheSubmapBegan) {
  RegistrationSchedule schedule({}, kFull);
  schedule.OnScan(ScanTime(0), 1, kPoints);
  for (int i = 1; i <= 50; ++i) {
    schedule.OnScan(ScanTime(20 * i), std::min(i + 1, kFull), kPoints);
  }
  EXPECT_EQ(schedule.SinceBegin(), milliseconds(1000)) << "however few scans are kept";
  schedule.OnScan(ScanTime(5000), 1, kPoints);
  EXPECT_EQ(schedule.SinceBegin(), milliseconds(0));
}

TEST(RegistrationScheduleTest, RadarsThatFollowOneAnotherShareARegistration) {
  RegistrationSchedule schedule({}, kFull);
  EXPECT_FALSE(schedule.SinceRegistration().has_value());
  schedule.OnScan(ScanTime(0), kFull, kPoints);
  schedule.OnRegistration();
  schedule.OnScan(ScanTime(39), kFull, kPoints);
  EXPECT_FALSE(schedule.IsDue(false));
  EXPECT_EQ(*schedule.SinceRegistration(), milliseconds(39));
  schedule.OnScan(ScanTime(40), kFull, kPoints);
  EXPECT_TRUE(schedule.IsDue(false));
}

TEST(RegistrationScheduleTest, ASteadyTrackerRegistersEverySecondScan) {
  RegistrationSchedule schedule({}, kFull);
  schedule.OnScan(ScanTime(0), kFull, kPoints);
  schedule.OnRegistration();
  schedule.OnScan(ScanTime(80), kFull, kPoints);
  EXPECT_FALSE(schedule.IsDue(true));
  EXPECT_TRUE(schedule.IsDue(false));
  schedule.OnScan(ScanTime(160), kFull, kPoints);
  EXPECT_TRUE(schedule.IsDue(true));
}

TEST(RegistrationScheduleTest, NewPointsAreCountedUntilTheyAreEnough) {
  const std::size_t enough = RegistrationScheduleOptions().min_new_points;
  RegistrationSchedule schedule({}, kFull);
  schedule.OnScan(ScanTime(0), kFull, enough - 1);
  EXPECT_FALSE(schedule.has_new_points());
  schedule.OnRegistration();
  schedule.OnScan(ScanTime(80), kFull, 1);
  EXPECT_TRUE(schedule.has_new_points());
  schedule.OnRegistration();
  schedule.OnScan(ScanTime(160), kFull, 0);
  EXPECT_FALSE(schedule.has_new_points());
}

TEST(RegistrationScheduleTest, PointsOfALateScanAreNew) {
  const std::size_t enough = RegistrationScheduleOptions().min_new_points;
  RegistrationSchedule schedule({}, kFull);
  schedule.OnScan(ScanTime(0), kFull, enough);
  schedule.OnRegistration();
  schedule.OnLateScan(enough);
  EXPECT_TRUE(schedule.has_new_points());
  EXPECT_FALSE(schedule.IsDue(true)) << "a registration follows the newest scan";
}

}  // namespace
}  // namespace dcloc
