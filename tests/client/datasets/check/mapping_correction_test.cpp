#include "client/datasets/check/mapping_correction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/geometry/covariance.h"

namespace dcloc {
namespace {

RadarMapping Corrected(RangeRateMeaning meaning, RadarMapping radar = {.id = "front"}) {
  const std::vector<RangeRateCheck> checks = {{.radar_id = "other"},
                                              {.radar_id = "front", .meaning = meaning}};
  return CorrectedMapping({.radars = {std::move(radar)}}, checks).radars[0];
}

TEST(MappingCorrectionTest, WhatTheDataShowIsBesideWhatTheMappingSays) {
  using enum RangeRateMeaning;
  EXPECT_TRUE(Corrected(kTowards).range_rate_is_towards);
  EXPECT_FALSE(Corrected(kTowards).azimuth_is_clockwise);
  const RadarMapping turned = {.id = "front", .range_rate_is_towards = true};
  EXPECT_FALSE(Corrected(kTowards, turned).range_rate_is_towards);
  EXPECT_TRUE(Corrected(kAwayMirrored, turned).azimuth_is_clockwise);
  EXPECT_TRUE(Corrected(kAwayMirrored, turned).range_rate_is_towards);
  EXPECT_TRUE(Corrected(kTowardsMirrored).azimuth_is_clockwise);
  EXPECT_TRUE(Corrected(kCompensated).range_rate_is_compensated);
}

TEST(MappingCorrectionTest, WhatNoSignMendsStays) {
  using enum RangeRateMeaning;
  for (const RangeRateMeaning meaning : {kUnknown, kAway, kOfAnotherMount, kNothingFits}) {
    const RadarMapping radar = Corrected(meaning);
    EXPECT_FALSE(radar.range_rate_is_towards || radar.azimuth_is_clockwise ||
                 radar.range_rate_is_compensated);
  }
}

TEST(MappingCorrectionTest, ALevelFrameKeepsWhatSitsOnItWhereItSits) {
  constexpr double kTilt_rad = 0.05;
  const Pose3 on_lidar{{1.0, 0.2, 0.3}, Eigen::Quaterniond::Identity()};
  BagMapping mapping{.radars = {{.id = "front"}}, .velocity_by_doppler = true};
  mapping.radars[0].T_vehicle_radar = on_lidar;
  mapping.T_vehicle_imu = mapping.T_vehicle_reference = Pose3();
  const BagMapping level = LevelMapping(mapping, kTilt_rad);
  // The way, which led up out of the old frame's plane, leads straight ahead.
  const Eigen::Vector3d way(std::cos(kTilt_rad), 0.0, std::sin(kTilt_rad));
  EXPECT_NEAR((level.T_vehicle_reference->Rotation() * way - Eigen::Vector3d::UnitX()).norm(), 0.0,
              1e-12);
  const Pose3 T_imu_radar = level.T_vehicle_imu->Inverse() * *level.radars[0].T_vehicle_radar;
  EXPECT_NEAR(Log(T_imu_radar.Inverse() * on_lidar).norm(), 0.0, 1e-12);

  mapping.T_vehicle_imu.reset();  // TF tells it
  EXPECT_FALSE(LevelMapping(mapping, kTilt_rad).T_vehicle_imu.has_value());
  EXPECT_TRUE(LevelMapping(mapping, kTilt_rad).T_vehicle_reference->translation_m.isZero());
  EXPECT_EQ(LevelMapping(mapping, kTilt_rad).radars[0].T_vehicle_radar->rotation.coeffs(),
            on_lidar.rotation.coeffs());
}

}  // namespace
}  // namespace dcloc
