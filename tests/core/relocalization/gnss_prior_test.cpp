#include "core/relocalization/gnss_prior.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/geometry/degrees.h"

namespace dcloc {
namespace {

const GeodeticAnchor kAnchor{
    .origin = {.latitude_deg = 52.0, .longitude_deg = 13.0, .height_m = 40.0}};

TEST(GnssPriorTest, AtTheAnchorIsTheOriginAndEastIsX) {
  GnssFix fix{.position = kAnchor.origin, .horizontal_sigma_m = 2.0, .vertical_sigma_m = 5.0};
  EXPECT_LT(PriorFromGnss(fix, kAnchor).T_map_vehicle.translation_m.norm(), 1e-6);
  fix.position.longitude_deg += 0.001;
  const Eigen::Vector3d p = PriorFromGnss(fix, kAnchor).T_map_vehicle.translation_m;
  EXPECT_NEAR(p.x(), 68.7, 0.5);
  EXPECT_NEAR(p.y(), 0.0, 0.1);
}

TEST(GnssPriorTest, AHeadingIsClockwiseFromNorth) {
  const GnssFix fix{.position = kAnchor.origin,
                    .horizontal_sigma_m = 2.0,
                    .vertical_sigma_m = 5.0,
                    .heading_deg = 30.0,
                    .heading_sigma_deg = 3.0};
  const InitialPose pose = PriorFromGnss(fix, kAnchor);
  EXPECT_NEAR(Yaw(pose.T_map_vehicle.rotation), 60.0 * kRadPerDeg, 1e-6);
  EXPECT_NEAR(std::sqrt(pose.covariance(5, 5)), 3.0 * kRadPerDeg, 1e-9);
}

TEST(GnssPriorTest, AHeadingThatNobodyKnowsIsAnyOfTheCircle) {
  const GnssFix fix{.position = kAnchor.origin,
                    .horizontal_sigma_m = 2.0,
                    .vertical_sigma_m = 5.0,
                    .heading_deg = std::nullopt,
                    .heading_sigma_deg = 3.0};
  const InitialPose pose = PriorFromGnss(fix, kAnchor);
  EXPECT_NEAR(pose.covariance(5, 5), std::numbers::pi * std::numbers::pi / 3.0, 1e-9);
  EXPECT_TRUE(Validate(pose).ok());
}

TEST(GnssPriorTest, APositionIsAsUncertainAlongEveryHorizontalAxis) {
  const InitialPose pose = PriorFromPosition({.p_map = {1.0, 2.0, 3.0},
                                              .horizontal_sigma_m = 2.0,
                                              .vertical_sigma_m = 5.0,
                                              .yaw_rad = 0.5,
                                              .yaw_sigma_rad = 0.1});
  EXPECT_EQ(pose.T_map_vehicle.translation_m, Eigen::Vector3d(1.0, 2.0, 3.0));
  EXPECT_NEAR(pose.covariance(0, 0), 4.0, 1e-12);
  EXPECT_NEAR(pose.covariance(1, 1), 4.0, 1e-12);
  EXPECT_NEAR(pose.covariance(2, 2), 25.0, 1e-12);
  EXPECT_NEAR(pose.covariance(3, 3), std::pow(3.0 * kRadPerDeg, 2), 1e-12);
  EXPECT_NEAR(pose.covariance(5, 5), 0.01, 1e-12);
}

}  // namespace
}  // namespace dcloc
