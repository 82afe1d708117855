#include "core/geometry/geodetic_anchor.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dcloc {
namespace {

const GeodeticAnchor kAnchor{
    .origin = {.latitude_deg = 48.4, .longitude_deg = 9.97, .height_m = 480.0},
    .x_axis_east_rad = 0.5};

TEST(GeodeticAnchorTest, RoundTrip) {
  const Eigen::Vector3d p_map(1234.5, -678.9, 12.0);
  const Eigen::Vector3d back = MapFromGeodetic(kAnchor, GeodeticFromMap(kAnchor, p_map));
  EXPECT_LT((back - p_map).norm(), 1e-6);
}

TEST(GeodeticAnchorTest, TheXAxisPointsWhereTheAnchorSays) {
  // One metre along x at 0 rad is one metre east; the radius of curvature gives the longitude.
  GeodeticAnchor east = kAnchor;
  east.x_axis_east_rad = 0.0;
  const GeodeticPosition moved = GeodeticFromMap(east, Eigen::Vector3d(1.0, 0.0, 0.0));
  const double phi = east.origin.latitude_deg * M_PI / 180.0;
  const double e2 = 0.00669437999014;
  const double normal_radius_m = 6378137.0 / std::sqrt(1.0 - e2 * std::pow(std::sin(phi), 2));
  const double expected_deg = 180.0 / M_PI / ((normal_radius_m + 480.0) * std::cos(phi));
  EXPECT_NEAR(moved.longitude_deg - 9.97, expected_deg, 1e-9);
  EXPECT_NEAR(moved.latitude_deg, 48.4, 1e-9);
}

TEST(GeodeticAnchorTest, ErrorsNameTheFieldTheValueAndTheBound) {
  GeodeticAnchor bad = kAnchor;
  bad.origin.latitude_deg = 91.0;
  EXPECT_EQ(Validate(bad).message(), "latitude_deg is 91; it must lie in [-90, 90]");
  bad = kAnchor;
  bad.origin.longitude_deg = std::nan("");
  EXPECT_FALSE(Validate(bad).ok());
  EXPECT_TRUE(Validate(kAnchor).ok());
}

}  // namespace
}  // namespace dcloc
