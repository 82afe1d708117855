#include "core/map/landmark_points.h"

#include <gtest/gtest.h>

#include <numbers>

namespace dcloc {
namespace {

const Pose3 kTurnedLeft{.translation_m = {10.0, 20.0, 0.0},
                        .rotation = Eigen::Quaterniond(
                            Eigen::AngleAxisd(0.5 * std::numbers::pi, Eigen::Vector3d::UnitZ()))};

TEST(LandmarkPointsTest, AReturnLiesWhereTheVehicleSawIt) {
  RadarPoint point{.position_m = {5.0, 1.0, 0.0},
                   .covariance_m2 = Eigen::Vector3d(0.04, 0.25, 1.0).asDiagonal(),
                   .rcs_dbsm = 3.0F,
                   .slant_per_m = {0.1, 0.0}};
  std::vector<MapReturn> returns;
  AppendReturns({&point, 1}, kTurnedLeft, 7, returns);
  ASSERT_EQ(returns.size(), 1U);
  EXPECT_TRUE(returns[0].position_m.isApprox(Eigen::Vector3d(9.0, 25.0, 0.0)));
  EXPECT_NEAR(returns[0].covariance_m2[0], 0.25, 1e-6);
  EXPECT_NEAR(returns[0].covariance_m2[3], 0.04, 1e-6);
  EXPECT_NEAR(returns[0].slant_per_m[1], 0.1, 1e-6);
  EXPECT_EQ(returns[0].scan, 7U);
}

TEST(LandmarkPointsTest, ARecordIsInItsKeyframesFrameAndItsCountsSaturate) {
  const Landmark landmark{.position_m = {9.0, 25.0, 0.0},
                          .covariance_m2 = Eigen::Vector3d(0.25, 0.04, 1.0).asDiagonal(),
                          .rcs_dbsm = 3.0F,
                          .scan_count = 70'000,
                          .pass_count = 2,
                          .height_m = 1.5};
  const MapPoint point = PointInKeyframe(landmark, kTurnedLeft, true);
  EXPECT_NEAR(point.x_m, 5.0, 1e-5);
  EXPECT_NEAR(point.y_m, 1.0, 1e-5);
  EXPECT_NEAR(point.z_m, 1.5, 1e-6);
  EXPECT_NEAR(point.xx_m2, 0.04, 1e-6);
  EXPECT_EQ(point.scan_count, 65'535);
  EXPECT_EQ(point.pass_count, 2);
  EXPECT_NEAR(PointInKeyframe(landmark, kTurnedLeft, false).z_m, 0.0, 1e-6);
}

}  // namespace
}  // namespace dcloc
