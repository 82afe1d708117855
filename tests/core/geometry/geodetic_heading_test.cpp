#include "core/geometry/geodetic_heading.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/geometry/degrees.h"

namespace dcloc {
namespace {

const GeodeticAnchor kSlantedAnchor{
    .origin = {.latitude_deg = 48.4, .longitude_deg = 9.97, .height_m = 480.0},
    .x_axis_east_rad = 0.5};

Pose3 Standing(double x_m, double y_m, double yaw_rad) {
  return {.translation_m = {x_m, y_m, 0.0},
          .rotation = Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()))};
}

TEST(GeodeticHeadingTest, AtTheOriginTheXAxisHeadsWhereTheAnchorSays) {
  EXPECT_NEAR(HeadingFromMap(kSlantedAnchor, Standing(0.0, 0.0, 0.0)), 90.0 - 0.5 * kDegPerRad,
              1e-5);
  EXPECT_NEAR(HeadingFromMap(kSlantedAnchor, Standing(0.0, 0.0, -0.5)), 90.0, 1e-5);
}

TEST(GeodeticHeadingTest, YawAndHeadingAgreeFarFromTheOrigin) {
  for (const double yaw_rad : {-3.0, -1.0, 0.0, 1.07, 2.9}) {
    const Pose3 pose = Standing(40'000.0, 25'000.0, yaw_rad);
    const double heading_deg = HeadingFromMap(kSlantedAnchor, pose);
    EXPECT_GE(heading_deg, 0.0);
    EXPECT_LT(heading_deg, 360.0);
    const GeodeticPosition position = GeodeticFromMap(kSlantedAnchor, pose.translation_m);
    EXPECT_NEAR(YawFromHeading(kSlantedAnchor, position, heading_deg), yaw_rad, 1e-4);
  }
}

TEST(GeodeticHeadingTest, NorthTurnsWithThePlace) {
  // Meridians converge by sin(latitude) times the way along the circle of latitude.
  GeodeticAnchor east = kSlantedAnchor;
  east.x_axis_east_rad = 0.0;
  const Pose3 pose = Standing(40'000.0, 0.0, 0.0);
  const double longitude_deg = GeodeticFromMap(east, pose.translation_m).longitude_deg;
  const double turned_deg =
      (longitude_deg - east.origin.longitude_deg) * std::sin(48.4 * kRadPerDeg);
  EXPECT_GT(turned_deg, 0.3);
  EXPECT_NEAR(HeadingFromMap(east, pose), 90.0 + turned_deg, 1e-2);
}

}  // namespace
}  // namespace dcloc
