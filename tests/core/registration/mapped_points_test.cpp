#include "core/registration/mapped_points.h"

#include <gtest/gtest.h>

#include <numbers>
#include <vector>

namespace dcloc {
namespace {

GaussianPoint<2> MappedPointAt(double x_m, double y_m) {
  GaussianPoint<2> point;
  point.mean_m = {x_m, y_m};
  point.covariance_m2 = 0.01 * Eigen::Matrix2d::Identity();
  return point;
}

TEST(MappedPointsTest, APointCountsWithinReachOfALandmark) {
  const LocalMap<2> map(Pose3{}, {MappedPointAt(10, 0), MappedPointAt(20, 30)});
  const std::vector<GaussianPoint<2>> points = {MappedPointAt(10, 0),   MappedPointAt(13.9, 0),
                                                MappedPointAt(14.1, 0), MappedPointAt(20, 26.5),
                                                MappedPointAt(-100, 0), MappedPointAt(100, 100)};
  EXPECT_EQ(CountMappedPoints<2>(points, map, Pose2{}, 4.0), 3U);
  EXPECT_EQ(CountMappedPoints<2>(points, map, Pose2{}, 4.2), 4U);
}

TEST(MappedPointsTest, PointsAreSeenFromThePose) {
  const LocalMap<2> map(Pose3{}, {MappedPointAt(10, 50)});
  Pose2 T_local_vehicle;
  T_local_vehicle.translation_m = {10, 0};
  T_local_vehicle.yaw_rad = 0.5 * std::numbers::pi;
  const std::vector<GaussianPoint<2>> points = {MappedPointAt(50, 0), MappedPointAt(0, 50)};
  EXPECT_EQ(CountMappedPoints<2>(points, map, T_local_vehicle, 1.0), 1U);
}

TEST(MappedPointsTest, NothingIsMappedWithoutLandmarks) {
  const std::vector<GaussianPoint<2>> points = {MappedPointAt(0, 0)};
  EXPECT_EQ(CountMappedPoints<2>(points, LocalMap<2>{}, Pose2{}, 1e3), 0U);
}

}  // namespace
}  // namespace dcloc
