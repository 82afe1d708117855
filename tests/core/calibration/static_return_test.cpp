#include "core/calibration/static_return.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/radar/measurement.h"
#include "core/radar/static_points.h"

namespace dcloc {
namespace {

const EgoVelocity kEgo{.linear_mps = {12.0, 0.4, 0.0}, .angular_radps = {0.0, 0.0, 0.15}};

RadarModel Radar(double beta_s) {
  RadarModel radar{.id = "corner", .beta_s = beta_s};
  radar.T_vehicle_radar = Embed(Pose2{.translation_m = {3.2, -0.8}, .yaw_rad = -0.9});
  return radar;
}

Scan OneTarget(const RadarModel& radar) {
  const double azimuth_rad = 0.35;
  const Eigen::Vector3d u_vehicle =
      radar.T_vehicle_radar.Rotation() *
      Eigen::Vector3d(std::cos(azimuth_rad), std::sin(azimuth_rad), 0.0);
  Scan scan{.radar_id = radar.id};
  scan.range_m = {37.0F};
  scan.range_rate_mps = {
      static_cast<float>(PredictedRangeRate(u_vehicle, radar.T_vehicle_radar, kEgo))};
  scan.azimuth_rad = {static_cast<float>(azimuth_rad)};
  return scan;
}

Eigen::Vector2d PointOf(const RadarModel& radar, const Scan& scan) {
  const auto points = StaticPoints(scan, radar, kEgo, {});
  EXPECT_EQ(points.size(), 1U);
  return points.at(0).position_m.head<2>();
}

// The vehicle stands in the map's origin, so that the map's frame is the vehicle's.
ScanGeometry GeometryOf(const RadarModel& radar) {
  const Eigen::Vector3d& mount_m = radar.T_vehicle_radar.translation_m;
  const Eigen::Vector3d velocity_mps = kEgo.linear_mps + kEgo.angular_radps.cross(mount_m);
  return {.radar_m = mount_m.head<2>(),
          .radar_velocity_mps = velocity_mps.head<2>(),
          .vehicle_m = Eigen::Vector2d::Zero(),
          .vehicle_velocity_mps = kEgo.linear_mps.head<2>(),
          .yaw_rate_radps = kEgo.angular_radps.z(),
          .planar = true,
          .radar = 0,
          .stand = 0};
}

class JacobianTest : public ::testing::TestWithParam<CalibrationParameter> {};

// What the calibrator takes for the effect of a parameter is what the pipeline makes of it.
TEST_P(JacobianTest, IsHowTheCorrectedDescriptionMovesTheTarget) {
  constexpr double kStep = 1e-3;
  const RadarModel radar = Radar(0.02);
  const Scan scan = OneTarget(radar);
  const Eigen::Vector2d less = PointOf(Corrected(radar, GetParam(), -kStep), scan);
  const Eigen::Vector2d more = PointOf(Corrected(radar, GetParam(), kStep), scan);
  const Eigen::Vector2d numeric = (more - less) / (2.0 * kStep);
  const auto jacobian = JacobianByParameters(GeometryOf(radar), PointOf(radar, scan), 1.0);
  const Eigen::Vector2d column = jacobian.col(static_cast<Eigen::Index>(GetParam()));
  EXPECT_LT((column - numeric).norm(), 1e-3 * (1.0 + numeric.norm()));
}

INSTANTIATE_TEST_SUITE_P(Parameters, JacobianTest,
                         ::testing::Values(CalibrationParameter::kBeta,
                                           CalibrationParameter::kTimeOffset,
                                           CalibrationParameter::kRangeBias,
                                           CalibrationParameter::kMountYaw),
                         [](const auto& param) { return std::string(NameOf(param.param)); });

TEST(HeightTest, BringsATargetAbovePlanarRadarsNearer) {
  constexpr double kHeight_m = 2.0;
  const ScanGeometry scan = GeometryOf(Radar(0.0));
  const Eigen::Vector2d ground_m = scan.radar_m + Eigen::Vector2d(0.0, 30.0);
  const double slant_m = std::hypot(30.0, kHeight_m);
  const Eigen::Vector2d seen_m = scan.radar_m + Eigen::Vector2d(0.0, slant_m);
  const Eigen::Vector2d column =
      JacobianByParameters(scan, seen_m, 1.0)
          .col(static_cast<Eigen::Index>(CalibrationParameter::kHeightSquare));
  EXPECT_LT((seen_m + kHeight_m * kHeight_m * column - ground_m).norm(), 1e-3);
}

TEST(RangeScaleTest, BringsATargetNearerByAShareOfItsRange) {
  const ScanGeometry scan = GeometryOf(Radar(0.0));
  const Eigen::Vector2d seen_m = scan.radar_m + Eigen::Vector2d(0.0, 30.0);
  const auto jacobian = JacobianByParameters(scan, seen_m, 1.0);
  const Eigen::Vector2d column =
      jacobian.col(static_cast<Eigen::Index>(CalibrationParameter::kRangeScale));
  EXPECT_LT((0.01 * column - Eigen::Vector2d(0.0, -0.3)).norm(), 1e-12);
}

TEST(HeightTest, IsNothingToARadarThatMeasuresIt) {
  ScanGeometry scan = GeometryOf(Radar(0.0));
  scan.planar = false;
  const auto jacobian = JacobianByParameters(scan, {20.0, 10.0}, 0.99);
  EXPECT_TRUE(
      jacobian.col(static_cast<Eigen::Index>(CalibrationParameter::kHeightSquare)).isZero());
}

}  // namespace
}  // namespace dcloc
