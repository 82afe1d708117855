#include "client/datasets/check/scan_statistics.h"

#include <gtest/gtest.h>

#include "tests/client/datasets/two_radars.h"

namespace dcloc {
namespace {

TEST(ScanStatisticsTest, CountsWhatARadarSaw) {
  Drive drive = TwoRadars();
  drive.scans[0].scan.ego_velocity.reset();
  Scan& empty = drive.scans[2].scan;
  empty = {.stamp = empty.stamp, .radar_id = empty.radar_id};
  std::erase_if(drive.scans, [&](const DriveScan& entry) {
    return entry.scan.stamp == TwoRadars().scans[10].scan.stamp;
  });
  drive.rig.radars.push_back({.id = "silent"});
  const std::vector<ScanStatistics> statistics = ScanStatisticsOf(drive);
  ASSERT_EQ(statistics.size(), 3U);
  EXPECT_EQ(statistics[0].radar_id, "front");
  EXPECT_EQ(statistics[0].scan_count, 19U);
  EXPECT_EQ(statistics[0].target_count, 18U * 30U);
  EXPECT_EQ(statistics[0].empty_count, 1U);
  EXPECT_EQ(statistics[0].velocity_count, 17U);
  EXPECT_NEAR(statistics[0].Rate_hz(), 1.0 / 0.14, 1e-3);
  EXPECT_NEAR(statistics[0].longest_gap_s, 0.28, 1e-6);
  EXPECT_EQ(statistics[1].velocity_count, 20U);
  EXPECT_EQ(statistics[2].scan_count, 0U);
  EXPECT_EQ(statistics[2].Rate_hz(), 0.0);
}

TEST(ScanStatisticsTest, SpansTheAzimuthsOfAllTargets) {
  Drive drive = TwoRadars();
  for (DriveScan& entry : drive.scans) {
    for (float& azimuth_rad : entry.scan.azimuth_rad) azimuth_rad = 0.1F;
  }
  drive.scans.front().scan.azimuth_rad.front() = -0.2F;
  drive.scans.back().scan.azimuth_rad.back() = 0.4F;  // of the other radar
  EXPECT_NEAR(ScanStatisticsOf(drive)[0].azimuth_span_rad, 0.3, 1e-6);
  EXPECT_NEAR(ScanStatisticsOf(drive)[1].azimuth_span_rad, 0.3, 1e-6);
  drive.scans.clear();
  EXPECT_EQ(ScanStatisticsOf(drive)[0].azimuth_span_rad, 0.0);
}

}  // namespace
}  // namespace dcloc
