#include "core/map/height_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>

namespace dcloc {
namespace {

// A scatterer at `position_m` and `height_m` over the radar, seen from a drive along x past it.
HeightFit SeenAlongX(const Eigen::Vector2d& position_m, double height_m) {
  HeightFit fit;
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector2d ray_m = position_m - Eigen::Vector2d(1.0 * i, 0.0);
    const double range_m = ray_m.norm();
    const Eigen::Vector2d slant_per_m = ray_m / range_m / (2.0 * range_m);
    const Eigen::Matrix2d information = 100.0 * Eigen::Matrix2d::Identity();
    fit.Add(information, slant_per_m, position_m + height_m * height_m * slant_per_m);
  }
  return fit;
}

TEST(HeightFitTest, FindsPositionAndHeightOfExactReturns) {
  const HeightFit::Solution solution = SeenAlongX({30.0, 8.0}, 3.0).Solve(0.0);
  EXPECT_NEAR(std::sqrt(solution.height_square_m2), 3.0, 1e-9);
  EXPECT_NEAR(solution.shift_m.x(), 30.0, 1e-9);
  EXPECT_NEAR(solution.shift_m.y(), 8.0, 1e-9);
}

TEST(HeightFitTest, APriorPullsTheHeightToThatOfTheRadar) {
  const HeightFit fit = SeenAlongX({30.0, 8.0}, 3.0);
  EXPECT_LT(fit.Solve(10.0).height_square_m2, 8.9);
  EXPECT_NEAR(fit.Solve(1e9).height_square_m2, 0.0, 1e-6);
}

TEST(HeightFitTest, NoSquareIsNegativeOrAboveTenMetres) {
  HeightFit shorter;  // ranges that are too short have no height
  for (const double x : {1.0, 2.0, 3.0}) {
    shorter.Add(Eigen::Matrix2d::Identity(), {x, 0.1}, {-x, 0.0});
  }
  EXPECT_EQ(shorter.Solve(0.0).height_square_m2, 0.0);
  EXPECT_EQ(SeenAlongX({30.0, 8.0}, 30.0).Solve(0.0).height_square_m2, 100.0);
}

}  // namespace
}  // namespace dcloc
