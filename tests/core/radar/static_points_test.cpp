#include "core/radar/static_points.h"

#include <gtest/gtest.h>

#include "tests/core/radar/scan_fixture.h"

namespace dcloc {
namespace {

const EgoVelocity kDriving{.linear_mps = {15.0, 0.0, 0.0}};

RadarModel CoupledRadar() {
  RadarModel radar = RadarAt("front", 3.6, 0.2, 0.3);
  radar.beta_s = 0.04;
  return radar;
}

// A target at a known place, measured by the coupled radar from a moving vehicle.
Scan ScanOf(const Eigen::Vector3d& p_vehicle, const RadarModel& radar) {
  const Eigen::Vector3d p_radar = radar.T_vehicle_radar.Inverse() * p_vehicle;
  const Eigen::Vector3d u_vehicle = radar.T_vehicle_radar.Rotation() * p_radar.normalized();
  const double rate_mps = PredictedRangeRate(u_vehicle, radar.T_vehicle_radar, kDriving);
  Scan scan;
  scan.radar_id = radar.id;
  scan.range_m = {static_cast<float>(p_radar.norm() + radar.beta_s * rate_mps)};
  scan.range_rate_mps = {static_cast<float>(rate_mps)};
  scan.azimuth_rad = {static_cast<float>(std::atan2(p_radar.y(), p_radar.x()))};
  return scan;
}

TEST(StaticPointsTest, PutsACompensatedTargetWhereItIs) {
  const RadarModel radar = CoupledRadar();
  const Eigen::Vector3d truth(40.0, 8.0, 0.0);
  const auto points = StaticPoints(ScanOf(truth, radar), radar, kDriving, {});
  ASSERT_EQ(points.size(), 1U);
  EXPECT_LT((points[0].position_m - truth).norm(), 1e-4);
}

TEST(StaticPointsTest, WithoutCompensationItIsTooNear) {
  const RadarModel radar = CoupledRadar();
  const Eigen::Vector3d truth(40.0, 0.0, 0.0);
  const auto points = StaticPoints(ScanOf(truth, radar), radar, kDriving, {.compensate = false});
  ASSERT_EQ(points.size(), 1U);
  EXPECT_NEAR(points[0].position_m.x(), 40.0 - 0.04 * 15.0, 0.01);
}

TEST(StaticPointsTest, ReportsWhatAHeightWouldMoveItBy) {
  RadarModel radar = CoupledRadar();
  const Eigen::Vector3d on_ground(20.0, 8.0, 0.0);
  constexpr double kHeight_m = 2.0;
  const Eigen::Vector3d up = on_ground + kHeight_m * Eigen::Vector3d::UnitZ();
  const auto points = StaticPoints(ScanOf(up, radar), radar, kDriving, {});
  ASSERT_EQ(points.size(), 1U);
  const Eigen::Vector2d seen_m = points[0].position_m.head<2>();
  EXPECT_GT((seen_m - on_ground.head<2>()).norm(), 0.09);
  const Eigen::Vector2d mended_m = seen_m - kHeight_m * kHeight_m * points[0].slant_per_m;
  EXPECT_LT((mended_m - on_ground.head<2>()).norm(), 0.005);
  radar.has_elevation = true;
  const auto spatial = StaticPoints(ScanOf(on_ground, radar), radar, kDriving, {});
  ASSERT_EQ(spatial.size(), 1U);
  EXPECT_EQ(spatial[0].slant_per_m, Eigen::Vector2d::Zero());
}

TEST(StaticPointsTest, LeavesOutWhatMoves) {
  const RadarModel radar = CoupledRadar();
  Scan scan = ScanOf({40.0, 8.0, 0.0}, radar);
  scan.range_rate_mps[0] += 2.0F;
  EXPECT_TRUE(StaticPoints(scan, radar, kDriving, {}).empty());
}

TEST(StaticPointsTest, UnfoldsAnAliasedTarget) {
  RadarModel radar = CoupledRadar();
  radar.unambiguous_range_rate_mps = 8.0;
  const Eigen::Vector3d truth(40.0, 8.0, 0.0);
  Scan scan = ScanOf(truth, radar);
  scan.range_rate_mps[0] += 16.0F;
  const auto points = StaticPoints(scan, radar, kDriving, {});
  ASSERT_EQ(points.size(), 1U);
  EXPECT_LT((points[0].position_m - truth).norm(), 1e-4);
}

TEST(StaticPointsTest, TheCovarianceTurnsWithTheMount) {
  RadarModel radar = CoupledRadar();
  radar.T_vehicle_radar = Embed(Pose2{.yaw_rad = std::acos(0.0)});  // looks left
  radar.beta_s = 0.0;
  const auto points = StaticPoints(ScanOf({0.0, 50.0, 0.0}, radar), radar, kDriving, {});
  ASSERT_EQ(points.size(), 1U);
  const double across_m = 50.0 * radar.azimuth_sigma_rad;
  EXPECT_NEAR(points[0].covariance_m2(1, 1), std::pow(radar.range_sigma_m, 2), 1e-6);
  EXPECT_NEAR(points[0].covariance_m2(0, 0), across_m * across_m, 1e-3);
}

TEST(StaticPointsTest, WithoutUncertaintyAllPointsWeighTheSame) {
  const RadarModel radar = CoupledRadar();
  const auto near = StaticPoints(ScanOf({10.0, 1.0, 0.0}, radar), radar, kDriving,
                                 {.per_point_covariance = false});
  const auto far = StaticPoints(ScanOf({70.0, 9.0, 0.0}, radar), radar, kDriving,
                                {.per_point_covariance = false});
  ASSERT_EQ(near.size() + far.size(), 2U);
  EXPECT_EQ(near[0].covariance_m2, far[0].covariance_m2);
}

}  // namespace
}  // namespace dcloc
