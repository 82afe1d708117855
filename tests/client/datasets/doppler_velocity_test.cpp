// The velocity of a vehicle that sends none, by the range rates of its radar and a gyroscope.
#include "client/datasets/doppler_velocity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace dcloc {
namespace {

RadarModel RadarAt(const Eigen::Vector3d& place_m, double yaw_rad) {
  RadarModel radar;
  radar.id = "front";
  radar.T_vehicle_radar = {
      place_m, Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()))};
  return radar;
}

/// What stands all round, as the radar of a vehicle that moves so sees it.
Scan ScanOf(const RadarModel& radar, const EgoVelocity& velocity) {
  const Eigen::Vector3d v_radar =
      radar.T_vehicle_radar.rotation.conjugate() *
      (velocity.linear_mps + velocity.angular_radps.cross(radar.T_vehicle_radar.translation_m));
  Scan scan;
  scan.radar_id = radar.id;
  for (int i = 0; i < 60; ++i) {
    const double azimuth = -1.0 + i / 30.0;
    scan.range_m.push_back(20.0F + static_cast<float>(i));
    scan.azimuth_rad.push_back(static_cast<float>(azimuth));
    scan.range_rate_mps.push_back(
        static_cast<float>(-(v_radar.x() * std::cos(azimuth) + v_radar.y() * std::sin(azimuth))));
  }
  return scan;
}

TEST(DopplerVelocityTest, IsTheVehiclesWhereverItsFrameLies) {
  // In the radar itself, ahead of an axle, behind it, and to the side with a radar that looks
  // aside.
  for (const Eigen::Vector3d& place :
       {Eigen::Vector3d(0.0, 0.0, 0.07), Eigen::Vector3d(3.4, 0.0, 0.5),
        Eigen::Vector3d(-1.0, 0.0, 0.5), Eigen::Vector3d(1.0, 0.8, 0.5)}) {
    const RadarModel radar = RadarAt(place, 0.1);
    const EgoVelocity truth{{12.0, 0.7, 0.0}, {0.0, 0.0, 0.25}, std::nullopt};
    const auto velocity = VelocityByDoppler(ScanOf(radar, truth), radar, truth.angular_radps);
    ASSERT_TRUE(velocity.has_value());
    EXPECT_NEAR(velocity->linear_mps.x(), 12.0, 0.01) << place.transpose();
    EXPECT_NEAR(velocity->linear_mps.y(), 0.7, 0.02) << place.transpose();
    EXPECT_EQ(velocity->angular_radps.z(), 0.25);
    ASSERT_TRUE(velocity->covariance.has_value());
    EXPECT_GT((*velocity->covariance)(0, 0), 0.0);
  }
}

TEST(DopplerVelocityTest, IsAbsentWhereTargetsAreFew) {
  Scan scan;
  scan.radar_id = "front";
  EXPECT_FALSE(VelocityByDoppler(scan, RadarAt({0.0, 0.0, 0.0}, 0.0), Eigen::Vector3d::Zero()));
}

}  // namespace
}  // namespace dcloc
