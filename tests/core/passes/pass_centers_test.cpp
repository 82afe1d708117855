#include "core/passes/pass_centers.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/core/passes/street_fixture.h"

namespace dcloc {
namespace {

class PassCentersTest : public testing::Test {
 protected:
  std::vector<Landmark> Fuse(int min_scan_count, ScanChoice choice = ScanChoice::kAll) const {
    const std::vector<const PlacedPass*> passes = {&first_, &second_};
    return FusePasses(passes, origin_m_, min_scan_count, choice);
  }

  TestStreet street_;
  PlacedPass first_ = street_.Pass(1, "a");
  PlacedPass second_ = street_.Pass(2, "b");
  Eigen::Vector3d origin_m_ = {50.0, -20.0, 0.0};
};

TEST_F(PassCentersTest, ScatterersLieWherePassesSawThem) {
  const std::vector<LandmarkPosition> centers = PositionsOf(Fuse(20));
  ASSERT_FALSE(centers.empty());
  for (const LandmarkPosition& center : centers) {
    const Eigen::Vector2d p_map_m = center.position_m + origin_m_.head<2>();
    const bool is_scatterer = std::ranges::any_of(
        street_.scatterers_m,
        [&](const Eigen::Vector2d& p_m) { return (p_m - p_map_m).norm() < 0.2; });
    EXPECT_TRUE(is_scatterer) << p_map_m.transpose();
  }
}

TEST_F(PassCentersTest, EachPassCountsOnce) {
  const std::vector<Landmark> centers = Fuse(20);
  EXPECT_TRUE(
      std::ranges::any_of(centers, [](const Landmark& center) { return center.pass_count == 2; }));
  EXPECT_TRUE(
      std::ranges::none_of(centers, [](const Landmark& center) { return center.pass_count > 2; }));
}

TEST_F(PassCentersTest, WhatFewScansSawIsLeftOut) {
  for (const Landmark& center : Fuse(30)) EXPECT_GE(center.scan_count, 30U);
  EXPECT_LT(Fuse(30).size(), Fuse(2).size());
}

TEST_F(PassCentersTest, OnlyScansThatCountAreFused) {
  for (PlacedScan& scan : second_.scans) scan.is_good = false;
  for (const Landmark& center : Fuse(2)) EXPECT_EQ(center.pass_count, 1U);
  EXPECT_TRUE(Fuse(2, ScanChoice::kBeyondMap).empty());
}

}  // namespace
}  // namespace dcloc
