#include "client/evaluation/faults/target_faults.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tests/client/evaluation/faults/made_stream.h"

namespace dcloc::faults {
namespace {

const Window kSecondSecond = {MadeStamp(1.0), MadeStamp(2.0)};

bool IsChanged(const StreamScan& entry) {
  return entry.scan.radar_id == "a" && kSecondSecond.Contains(entry.measured);
}

TEST(TargetFaultsTest, FrozenTargetsAreThoseOfTheLastScanBefore) {
  Stream stream = MadeStream(3.0, 2);
  for (std::size_t i = 0; i < stream.scans.size(); ++i) {
    stream.scans[i].scan.range_m[0] = static_cast<float>(i + 1);
  }
  FreezeTargets(stream, kSecondSecond, "a");
  for (std::size_t i = 0; i < stream.scans.size(); ++i) {
    const Scan& scan = stream.scans[i].scan;
    EXPECT_EQ(scan.stamp, stream.scans[i].measured);
    EXPECT_NEAR(scan.ego_velocity->angular_radps.z(),
                0.01 * std::chrono::duration<double>(scan.stamp - MadeStamp(0.0)).count(), 1e-9);
    EXPECT_EQ(scan.range_m[0], IsChanged(stream.scans[i]) ? 19.0F : static_cast<float>(i + 1));
  }
}

TEST(TargetFaultsTest, RangeRatesAreZeroOrWithoutTheEgoMotion) {
  Stream stream = MadeStream(3.0, 2);
  ZeroRangeRates(stream, kSecondSecond, "a");
  for (const StreamScan& entry : stream.scans) {
    EXPECT_EQ(entry.scan.range_rate_mps[3], IsChanged(entry) ? 0.0F : -9.0F);
  }
  Stream compensated = MadeStream(3.0, 1);
  CompensateRangeRates(compensated, kSecondSecond);
  for (const StreamScan& entry : compensated.scans) {
    const double speed_mps = entry.scan.ego_velocity->linear_mps.x();
    const double ahead = std::cos(static_cast<double>(entry.scan.azimuth_rad[3]));
    EXPECT_NEAR(static_cast<double>(entry.scan.range_rate_mps[3]),
                IsChanged(entry) ? -9.0 + speed_mps * ahead : -9.0, 1e-3);
  }
}

TEST(TargetFaultsTest, GhostsAreAShareOfTheTargetsWithinTheView) {
  Stream stream = MadeStream(3.0, 1);
  ReplaceByGhosts(stream, kSecondSecond, std::nullopt, 0.8, 3);
  int ghosts = 0;
  for (const StreamScan& entry : stream.scans) {
    for (std::size_t row = 0; row < entry.scan.size(); ++row) {
      EXPECT_GE(entry.scan.azimuth_rad[row], -0.4501F);
      EXPECT_LE(entry.scan.azimuth_rad[row], 0.4501F);
      if (entry.scan.range_rate_mps[row] == -9.0F) continue;
      EXPECT_TRUE(IsChanged(entry));
      ++ghosts;
    }
  }
  EXPECT_NEAR(ghosts, 80, 15);
}

TEST(TargetFaultsTest, RangesAreLongerAndStayPositive) {
  Stream stream = MadeStream(3.0, 2);
  BiasRange(stream, kSecondSecond, "a", -25.0);
  for (const StreamScan& entry : stream.scans) {
    EXPECT_FLOAT_EQ(entry.scan.range_m[9], IsChanged(entry) ? 4.0F : 29.0F);
    EXPECT_GT(entry.scan.range_m[0], 0.0F);
  }
}

TEST(TargetFaultsTest, TheOwnBodyStandsStillBesideWhatIsSeen) {
  Stream stream = MadeStream(3.0, 1);
  for (StreamScan& entry : stream.scans) entry.scan.range_sigma_m.assign(10, 0.1F);
  AddOwnBody(stream, kSecondSecond, 3);
  for (const StreamScan& entry : stream.scans) {
    const Scan& scan = entry.scan;
    ASSERT_EQ(scan.size(), IsChanged(entry) ? 20U : 10U);
    EXPECT_EQ(scan.range_sigma_m.size(), scan.size());
    EXPECT_TRUE(scan.elevation_rad.empty());
    EXPECT_EQ(scan.range_rate_mps[9], -9.0F);
    for (std::size_t row = 10; row < scan.size(); ++row) {
      EXPECT_LT(std::abs(scan.range_rate_mps[row]), 0.5F);
      EXPECT_LE(scan.range_m[row], 15.0F);
    }
  }
}

TEST(TargetFaultsTest, ABlockedRadarSeesWhatIsNear) {
  Stream stream = MadeStream(3.0, 2);
  for (StreamScan& entry : stream.scans) entry.scan.range_sigma_m.assign(10, 0.1F);
  BlockView(stream, kSecondSecond, "a", 24.5);
  for (const StreamScan& entry : stream.scans) {
    const std::size_t size = IsChanged(entry) ? 5 : 10;
    EXPECT_EQ(entry.scan.size(), size);
    EXPECT_EQ(entry.scan.range_sigma_m.size(), size);
    EXPECT_TRUE(entry.scan.elevation_rad.empty());
  }
}

TEST(TargetFaultsTest, EachHasANameOfItsOwn) {
  std::set<std::string> ids;
  for (const Fault& fault : TargetFaults()) {
    EXPECT_EQ(fault.family, "targets");
    EXPECT_TRUE(ids.insert(fault.id).second) << fault.id;
  }
}

}  // namespace
}  // namespace dcloc::faults
