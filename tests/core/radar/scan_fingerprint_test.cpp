#include "core/radar/scan_fingerprint.h"

#include <gtest/gtest.h>

namespace dcloc {
namespace {

Scan ScanAt(int ms, float range_m) {
  return {.stamp = Stamp(std::chrono::milliseconds(ms)),
          .radar_id = "front",
          .range_m = {range_m, 20.0F},
          .range_rate_mps = {-3.0F, -4.0F},
          .azimuth_rad = {0.1F, 0.2F}};
}

TEST(ScanFingerprintTest, TheSameScanHasTheSameFingerprintAndNoOtherHas) {
  const std::uint64_t one = FingerprintOf(ScanAt(100, 10.0F));
  EXPECT_EQ(FingerprintOf(ScanAt(100, 10.0F)), one);
  EXPECT_NE(FingerprintOf(ScanAt(101, 10.0F)), one);
  EXPECT_NE(FingerprintOf(ScanAt(100, 10.1F)), one);
  Scan other = ScanAt(100, 10.0F);
  other.radar_id = "rear";
  EXPECT_NE(FingerprintOf(other), one);
  other = ScanAt(100, 10.0F);
  other.range_rate_mps[1] = -4.5F;
  EXPECT_NE(FingerprintOf(other), one);
}

TEST(ScanFingerprintTest, ThatOfTargetsIsOfThemAlone) {
  const std::uint64_t one = FingerprintOfTargets(ScanAt(100, 10.0F));
  EXPECT_EQ(FingerprintOfTargets(ScanAt(101, 10.0F)), one);
  EXPECT_NE(FingerprintOfTargets(ScanAt(100, 10.1F)), one);
}

}  // namespace
}  // namespace dcloc
