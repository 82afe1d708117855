#include "client/evaluation/faults/mover_faults.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/client/evaluation/faults/made_stream.h"

namespace dcloc::faults {
namespace {

const Window kTwoSeconds = {MadeStamp(1.0), MadeStamp(3.0)};

/// What of a stream is not as it was: how many targets, and each with the time since the window.
template <typename Visit>
double ChangedShare(const Stream& stream, const Visit& visit) {
  const Stream before = MadeStream(4.0, static_cast<int>(stream.rig.radars.size()));
  double total = 0.0, changed = 0.0;
  for (std::size_t i = 0; i < stream.scans.size(); ++i) {
    const Scan& is = stream.scans[i].scan;
    const bool is_inside = kTwoSeconds.Contains(stream.scans[i].measured);
    for (std::size_t row = 0; row < is.size(); ++row) {
      if (is_inside) total += 1.0;
      if (is.range_rate_mps[row] == before.scans[i].scan.range_rate_mps[row]) continue;
      EXPECT_TRUE(is_inside);
      changed += 1.0;
      visit(stream.scans[i], row);
    }
  }
  return changed / total;
}

TEST(MoverFaultsTest, ATruckAsFastAsWeAreStandsStillBeforeUs) {
  Stream stream = MadeStream(4.0);
  PutTruckAhead(stream, kTwoSeconds, 10.0, 0.0, 1);
  const double share = ChangedShare(stream, [](const StreamScan& entry, std::size_t row) {
    EXPECT_NEAR(entry.scan.range_rate_mps[row], 0.0F, 1e-4F);
    EXPECT_GE(entry.scan.range_m[row], 10.0F);
    EXPECT_LE(entry.scan.range_m[row], 23.0F);
    EXPECT_LE(std::abs(entry.scan.azimuth_rad[row]), 0.13F);
  });
  EXPECT_NEAR(share, kMoverShare, 0.15);
}

TEST(MoverFaultsTest, ASlowerTruckComesNearer) {
  Stream stream = MadeStream(4.0);
  PutTruckAhead(stream, kTwoSeconds, 10.0, -3.0, 1);
  ChangedShare(stream, [](const StreamScan& entry, std::size_t row) {
    const double t_s = std::chrono::duration<double>(entry.measured - kTwoSeconds.begin).count();
    const double back_m = std::max(6.0, 10.0 - 3.0 * t_s);
    EXPECT_NEAR(entry.scan.range_rate_mps[row], -3.0F, 0.1F);
    EXPECT_GE(static_cast<double>(entry.scan.range_m[row]), back_m - 1e-3);
    EXPECT_LE(static_cast<double>(entry.scan.range_m[row]), back_m + 12.3);
  });
}

// Range-Doppler coupling shows a target that recedes too far away.
TEST(MoverFaultsTest, RangesAreCoupled) {
  Stream plain = MadeStream(4.0), coupled = plain;
  coupled.rig.radars[0].beta_s = 0.04;
  PutTruckAhead(plain, kTwoSeconds, 10.0, 3.0, 1);
  PutTruckAhead(coupled, kTwoSeconds, 10.0, 3.0, 1);
  ChangedShare(coupled, [&](const StreamScan& entry, std::size_t row) {
    const auto index = static_cast<std::size_t>(&entry - coupled.scans.data());
    EXPECT_NEAR(entry.scan.range_m[row] - plain.scans[index].scan.range_m[row], 0.12F, 0.01F);
  });
}

TEST(MoverFaultsTest, ATruckAheadIsNotSeenByRadarsThatLookElsewhere) {
  Stream stream = MadeStream(4.0, 2);
  stream.rig.radars[1].T_vehicle_radar.rotation =
      Eigen::AngleAxisd(std::numbers::pi / 2.0, Eigen::Vector3d::UnitZ());
  PutTruckAhead(stream, kTwoSeconds, 10.0, 0.0, 1);
  const double share = ChangedShare(
      stream, [](const StreamScan& entry, std::size_t) { EXPECT_EQ(entry.scan.radar_id, "a"); });
  EXPECT_NEAR(share, 0.5 * kMoverShare, 0.1);
}

TEST(MoverFaultsTest, AConvoyDrivesOnBothSides) {
  Stream stream = MadeStream(4.0);
  PutConvoyBeside(stream, kTwoSeconds, 1);
  int left = 0, right = 0;
  const double share = ChangedShare(stream, [&](const StreamScan& entry, std::size_t row) {
    const float y_m = entry.scan.range_m[row] * std::sin(entry.scan.azimuth_rad[row]);
    EXPECT_NEAR(std::abs(y_m), 3.5F, 1.01F);
    EXPECT_NEAR(entry.scan.range_rate_mps[row], 0.0F, 1e-4F);
    ++(y_m > 0.0F ? left : right);
  });
  EXPECT_NEAR(share, kMoverShare, 0.15);
  EXPECT_GT(left, 20);
  EXPECT_GT(right, 20);
}

}  // namespace
}  // namespace dcloc::faults
