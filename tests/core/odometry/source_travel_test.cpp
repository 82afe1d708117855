#include "core/odometry/source_travel.h"

#include <gtest/gtest.h>

namespace dcloc {
namespace {

constexpr double kStep_s = 0.1;
const OdometrySources kVehicle(0b011), kDoppler(0b100), kYawRate(0b010), kAll(0b111);

// Ten steps by wheels at 5 m/s and Doppler at 10 m/s, which are heard in each, or in one of two.
SourceTravel Travelled(bool doppler_is_rare) {
  SourceTravel travel;
  for (int i = 0; i < 10; ++i) {
    OdometryReadings readings{.wheel_speed = ScalarEstimate{5.0, 0.1},
                              .yaw_rate = ScalarEstimate{0.2, 0.1}};
    if (!doppler_is_rare || i % 2 == 0) readings.doppler_speed = ScalarEstimate{10.0, 0.1};
    travel.OnReadings(readings);
    travel.OnUsedMotion({0.5, 0.02}, kStep_s);
  }
  return travel;
}

TEST(SourceTravelTest, EachSourceHasAWayOfItsOwn) {
  for (const bool doppler_is_rare : {false, true}) {
    const SourceTravel travel = Travelled(doppler_is_rare);
    EXPECT_NEAR(travel.BeyondUsed(kVehicle).forward_m, 0.0, 1e-9);
    EXPECT_NEAR(travel.BeyondUsed(kVehicle).turn_rad, 0.0, 1e-9);
    EXPECT_NEAR(travel.BeyondUsed(kDoppler).forward_m, 5.0, 1e-9);
  }
}

TEST(SourceTravelTest, WhatSourcesDoNotTellIsTheMotionThatWasUsed) {
  const SourceTravel travel = Travelled(false);
  EXPECT_EQ(travel.BeyondUsed(kYawRate).forward_m, 0.0);
  EXPECT_EQ(travel.BeyondUsed(kDoppler).turn_rad, 0.0) << "a single radar tells no turn";
  EXPECT_EQ(SourceTravel().BeyondUsed(kAll).forward_m, 0.0);
}

TEST(SourceTravelTest, ACorrectionIsUsed) {
  SourceTravel travel = Travelled(false);
  travel.OnCorrection({5.0, 0.0});
  EXPECT_NEAR(travel.BeyondUsed(kDoppler).forward_m, 0.0, 1e-9);
  EXPECT_NEAR(travel.BeyondUsed(kVehicle).forward_m, -5.0, 1e-9);
}

TEST(SourceTravelTest, WhatWasBeforeIsForgotten) {
  SourceTravel travel = Travelled(false);
  travel.Begin();
  EXPECT_EQ(travel.BeyondUsed(kDoppler).forward_m, 0.0);
  travel.OnUsedMotion({0.5, 0.0}, kStep_s);
  EXPECT_NEAR(travel.BeyondUsed(kDoppler).forward_m, 0.5, 1e-9) << "it goes on at 10 m/s";
}

}  // namespace
}  // namespace dcloc
