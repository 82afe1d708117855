#include "core/geometry/planar_region.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace dcloc {
namespace {

using ::testing::HasSubstr;

PlanarRegion Box(double x0, double y0, double x1, double y1) {
  return {.polygons = {BoxPolygon({x0, y0}, {x1, y1})}};
}

TEST(PlanarRegionTest, ABoxHoldsWhatLiesBetweenItsCornersInAnyOrder) {
  for (const PlanarRegion& region : {Box(1, 2, 3, 5), Box(3, 5, 1, 2), Box(3, 2, 1, 5)}) {
    EXPECT_TRUE(Contains(region, {2.0, 3.0}));
    EXPECT_FALSE(Contains(region, {0.9, 3.0}));
    EXPECT_FALSE(Contains(region, {2.0, 5.1}));
    EXPECT_TRUE(Validate(region).ok());
  }
}

TEST(PlanarRegionTest, ARingWithinARingIsAHole) {
  PlanarPolygon polygon = BoxPolygon({0, 0}, {10, 10});
  polygon.rings_m.push_back(BoxPolygon({4, 4}, {6, 6}).rings_m[0]);
  const PlanarRegion region{.polygons = {polygon}};
  EXPECT_TRUE(Contains(region, {1.0, 1.0}));
  EXPECT_FALSE(Contains(region, {5.0, 5.0}));
  // Of several polygons the region is the union.
  EXPECT_TRUE(Contains({.polygons = {polygon, BoxPolygon({4, 4}, {6, 6})}}, {5.0, 5.0}));
}

TEST(PlanarRegionTest, APointOnASharedBorderIsInExactlyOnePolygon) {
  const Eigen::Vector2d a(0, 0), b(7.3, 0.1), c(6.9, 5.7), d(0.2, 6.1);
  const PlanarRegion lower{.polygons = {{.rings_m = {{a, b, c}}}}};
  const PlanarRegion upper{.polygons = {{.rings_m = {{a, c, d}}}}};
  int on_border = 0;
  for (int i = 1; i < 1000; ++i) {
    const Eigen::Vector2d p = a + (c - a) * (i / 1000.0);
    on_border += (Contains(lower, p) != Contains(upper, p)) ? 1 : 0;
  }
  EXPECT_EQ(on_border, 999);
  // Through a vertex on the left, too.
  EXPECT_FALSE(Contains(lower, {-1.0, 0.0}));
}

TEST(PlanarRegionTest, FarRingsAreNotWalkedRound) {
  // A thousand rings of a thousand vertices, and a point in each.
  PlanarRegion region;
  for (int i = 0; i < 1000; ++i) {
    auto& ring_m = region.polygons.emplace_back().rings_m.emplace_back();
    for (int k = 0; k < 1000; ++k) {
      const double angle_rad = 2.0 * M_PI * k / 1000.0;
      ring_m.emplace_back(10.0 * i + 4.0 * std::cos(angle_rad), 4.0 * std::sin(angle_rad));
    }
  }
  const RegionTest test(region);
  for (int i = 0; i < 1000; ++i) {
    EXPECT_TRUE(test.Holds({10.0 * i + 3.9, 0.5}));
    EXPECT_FALSE(test.Holds({10.0 * i + 3.9, 3.9}));  // in the box alone
    EXPECT_FALSE(test.Holds({10.0 * i + 5.0, 0.0}));
  }
  EXPECT_FALSE(RegionTest(PlanarRegion{.polygons = {{.rings_m = {{}}}}}).Holds({0.0, 0.0}));
}

TEST(PlanarRegionTest, ErrorsNameRingAndValue) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(Validate(PlanarRegion{}).message(), HasSubstr("no polygon"));
  EXPECT_THAT(Validate(Box(0, 0, nan, 1)).message(), HasSubstr("ring 0 a coordinate is nan"));
  EXPECT_THAT(Validate(Box(0, 0, 2e9, 1)).message(), HasSubstr("2e+09 m"));
  EXPECT_THAT(Validate(Box(0, 0, 0, 1)).message(), HasSubstr("area of 0 m^2"));
  EXPECT_THAT(Validate(PlanarRegion{.polygons = {{.rings_m = {{{0, 0}, {1, 1}}}}}}).message(),
              HasSubstr("has 2 vertices"));
}

}  // namespace
}  // namespace dcloc
