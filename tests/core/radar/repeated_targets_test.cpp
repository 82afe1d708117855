#include "core/radar/repeated_targets.h"

#include <gtest/gtest.h>

namespace dcloc {
namespace {

Scan ScanOf(int number, std::size_t target_count = 20) {
  Scan scan{.stamp = Stamp(std::chrono::milliseconds(number)), .radar_id = "front"};
  for (std::size_t i = 0; i < target_count; ++i) {
    scan.range_m.push_back(10.0F + static_cast<float>(i) + 0.01F * static_cast<float>(number));
    scan.range_rate_mps.push_back(-3.0F);
    scan.azimuth_rad.push_back(0.1F);
  }
  return scan;
}

TEST(RepeatedTargetsTest, AreThoseThatTheSameRadarSentBefore) {
  RepeatedTargets repeated(2);
  EXPECT_FALSE(repeated.OnScan(0, ScanOf(1)));
  EXPECT_FALSE(repeated.OnScan(1, ScanOf(1)));
  EXPECT_FALSE(repeated.OnScan(0, ScanOf(2)));
  Scan again = ScanOf(2);
  again.stamp += std::chrono::seconds(1);
  EXPECT_TRUE(repeated.OnScan(0, again));
  EXPECT_TRUE(repeated.OnScan(0, again));
  EXPECT_TRUE(repeated.OnScan(0, ScanOf(1))) << "a buffer of several scans";
  EXPECT_FALSE(repeated.OnScan(0, ScanOf(3)));
}

TEST(RepeatedTargetsTest, OfALongBufferEachIsFound) {
  RepeatedTargets repeated(1);
  for (int i = 0; i < 60; ++i) EXPECT_FALSE(repeated.OnScan(0, ScanOf(i)));
  for (int round = 0; round < 3; ++round) {
    for (int i = 0; i < 60; ++i) EXPECT_TRUE(repeated.OnScan(0, ScanOf(i))) << i;
  }
}

TEST(RepeatedTargetsTest, AFewTargetsMayRepeatByChance) {
  RepeatedTargets repeated(1);
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(repeated.OnScan(0, ScanOf(7, 4)));
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(repeated.OnScan(0, ScanOf(7, 0)));
}

}  // namespace
}  // namespace dcloc
