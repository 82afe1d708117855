#include "core/passes/landmark_refinement.h"

#include <gtest/gtest.h>

namespace dcloc {
namespace {

PlacedLandmark Base(double x_m, std::uint16_t pass_count) {
  PlacedLandmark landmark;
  landmark.position = {.position_m = {x_m, 0.0},
                       .covariance_m2 = 0.01 * Eigen::Matrix2d::Identity()};
  landmark.point.pass_count = pass_count;
  return landmark;
}

Landmark Fused(double x_m, std::uint32_t pass_count) {
  return {.position_m = {x_m, 0.0, 0.0},
          .covariance_m2 = 0.01 * Eigen::Matrix3d::Identity(),
          .rcs_dbsm = 0.0F,
          .scan_count = 10,
          .pass_count = pass_count};
}

TEST(LandmarkRefinementTest, EachWeighsByItsPasses) {
  const Landmark blend = Blend(Base(0.0, 1), Fused(0.4, 3));
  EXPECT_NEAR(blend.position_m.x(), 0.3, 1e-12);
  EXPECT_NEAR(blend.covariance_m2(0, 0), 0.01 + 0.25 * 0.75 * 0.16, 1e-12);
  EXPECT_NEAR(blend.covariance_m2(1, 1), 0.01, 1e-12);
  EXPECT_EQ(blend.pass_count, 4U);
}

TEST(LandmarkRefinementTest, WhatManyPassesSawHardlyMoves) {
  EXPECT_LT(Blend(Base(0.0, 60), Fused(0.4, 3)).position_m.x(), 0.02);
}

TEST(LandmarkRefinementTest, PlacesAreOfBothOrOfOne) {
  const std::vector<PlacedLandmark> base = {Base(0.0, 1), Base(10.0, 1)};
  const std::vector<Landmark> fused = {Fused(0.1, 1), Fused(20.0, 2)};
  const std::vector<LandmarkPosition> positions = BlendedPositions(base, fused, {});
  ASSERT_EQ(positions.size(), 3U);
  EXPECT_NEAR(positions[0].position_m.x(), 10.0, 1e-12);
  EXPECT_NEAR(positions[1].position_m.x(), 0.05, 1e-12);
  EXPECT_NEAR(positions[2].position_m.x(), 20.0, 1e-12);
}

}  // namespace
}  // namespace dcloc
