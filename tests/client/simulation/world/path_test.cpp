#include "client/simulation/world/path.h"

#include <gtest/gtest.h>

#include <numbers>

#include "client/simulation/world/steps.h"

namespace dcloc::simulation {
namespace {

Path Winding() {
  Path path;
  path.Append(12.3, 0.0);
  path.Append(9.0, 0.07);
  path.Append(14.0, 0.07);
  path.Append(20.0, -0.03);
  path.Append(11.0, 0.0);
  return path;
}

TEST(PathTest, HeadingAndCurvatureAreDerivatives) {
  const Path path = Winding();
  constexpr double kStep = 1e-5;
  for (const double s : Steps(-3.0, path.length_m() + 3.0, 0.37)) {
    const PathPoint before = path.At(s - kStep);
    const PathPoint here = path.At(s);
    const PathPoint after = path.At(s + kStep);
    const Eigen::Vector2d tangent = (after.position_m - before.position_m) / (2.0 * kStep);
    EXPECT_LT((tangent - Along(here.heading_rad)).norm(), 1e-8) << s;
    EXPECT_NEAR((after.heading_rad - before.heading_rad) / (2.0 * kStep), here.curvature_per_m,
                1e-7)
        << s;
    EXPECT_NEAR((after.curvature_per_m - before.curvature_per_m) / (2.0 * kStep),
                here.curvature_rate_per_m2, 1e-6)
        << s;
  }
}

TEST(PathTest, ArcLengthIsTheCurvesOwn) {
  const Path path = Winding();
  double length = 0.0;
  constexpr double kStep = 0.01;
  for (const double s : Steps(0.0, path.length_m() - 0.5 * kStep, kStep)) {
    length += (path.At(s + kStep).position_m - path.At(s).position_m).norm();
  }
  EXPECT_NEAR(length, path.length_m(), 1e-4 * path.length_m());
}

TEST(PathTest, BendTurnsByItsAngle) {
  for (const double angle : {0.5 * std::numbers::pi, -1.4, 0.05}) {
    Path path;
    path.Append(5.0, 0.0);
    path.AppendBend(angle, 20.0, 10.0);
    EXPECT_NEAR(path.At(path.length_m()).heading_rad, angle, 1e-12);
    EXPECT_EQ(path.At(path.length_m()).curvature_per_m, 0.0);
  }
}

TEST(PathTest, ReversedIsTheSameCurve) {
  const Path path = Winding();
  const Path back = path.Reversed();
  EXPECT_DOUBLE_EQ(back.length_m(), path.length_m());
  for (const double s : Steps(-5.0, path.length_m() + 5.0, 0.7)) {
    const PathPoint here = path.At(s);
    const PathPoint there = back.At(path.length_m() - s);
    EXPECT_LT((here.position_m - there.position_m).norm(), 1e-9) << s;
    EXPECT_NEAR(std::cos(here.heading_rad - there.heading_rad), -1.0, 1e-12) << s;
    EXPECT_NEAR(here.curvature_per_m, -there.curvature_per_m, 1e-12) << s;
    EXPECT_NEAR(here.curvature_rate_per_m2, there.curvature_rate_per_m2, 1e-12) << s;
  }
}

TEST(PathTest, GoesOnStraightBeyondItsEnds) {
  const Path path = Winding();
  EXPECT_EQ(path.At(-4.0).position_m, Eigen::Vector2d(-4.0, 0.0));
  const PathPoint end = path.At(path.length_m());
  const PathPoint beyond = path.At(path.length_m() + 7.0);
  EXPECT_LT((beyond.position_m - end.position_m - 7.0 * Along(end.heading_rad)).norm(), 1e-12);
}

}  // namespace
}  // namespace dcloc::simulation
