#include "core/odometry/single_radar_yaw_rate.h"

#include <gtest/gtest.h>

#include "core/geometry/degrees.h"

namespace dcloc {
namespace {

constexpr double kAhead_m = 3.6;
constexpr double kSpeed_mps = 5.0;

// By a radar that looks `angle_rad` aside, of a vehicle whose origin moves by `offset_m` of its
// turn to the side.
ScalarEstimate Doppler(double yaw_rate_radps, double angle_rad = 0.0, double offset_m = 0.0,
                       double speed_mps = kSpeed_mps) {
  return {yaw_rate_radps * (1.0 + offset_m / kAhead_m) + angle_rad * speed_mps / kAhead_m, 1e-4};
}

SingleRadarYawRate::Gyroscope Gyroscope(double yaw_rate_radps) {
  return {.yaw_rate_radps = yaw_rate_radps, .is_sound = true};
}

// The two have agreed on a straight road, but for the angle.
SingleRadarYawRate Agreed(double angle_rad = 0.0) {
  SingleRadarYawRate yaw_rate;
  for (int scan = 0; scan < 40; ++scan) {
    yaw_rate.OnYawRates(kSpeed_mps, kAhead_m, Doppler(0.0, angle_rad), Gyroscope(0.0));
  }
  return yaw_rate;
}

double Beyond(SingleRadarYawRate& yaw_rate, const ScalarEstimate& seen, double gyroscope_radps) {
  return yaw_rate.OnYawRates(kSpeed_mps, kAhead_m, seen, Gyroscope(gyroscope_radps))
      ->beyond_gyroscope_radps;
}

TEST(SingleRadarYawRateTest, ContradictsAGyroscopeThatMissesATurn) {
  SingleRadarYawRate yaw_rate = Agreed();
  for (int scan = 0; scan < 40; ++scan) {
    const auto reading = yaw_rate.OnYawRates(kSpeed_mps, kAhead_m, Doppler(0.45), Gyroscope(0.0));
    ASSERT_TRUE(reading.has_value());
    EXPECT_GT(reading->beyond_gyroscope_radps, 0.4) << "however long it lasts";
    EXPECT_NEAR(reading->yaw_rate.value, 0.45, 1e-9);
  }
  EXPECT_EQ(Beyond(yaw_rate, Doppler(0.0), 0.0), 0.0);
}

TEST(SingleRadarYawRateTest, AgreesInATurnWithAGyroscopeThatIsRight) {
  for (const double offset_m : {-1.4, 0.0, 1.4}) {  // where the vehicle frame's origin may be
    SingleRadarYawRate yaw_rate = Agreed();
    EXPECT_EQ(Beyond(yaw_rate, Doppler(0.45, 0.0, offset_m), 0.45), 0.0);
  }
}

TEST(SingleRadarYawRateTest, SaysNothingBeforeTheMountIsKnown) {
  SingleRadarYawRate yaw_rate;
  for (int scan = 0; scan < 20; ++scan) {
    EXPECT_FALSE(yaw_rate.OnYawRates(kSpeed_mps, kAhead_m, Doppler(0.0, 0.17), Gyroscope(0.0)))
        << scan;
  }
  EXPECT_FALSE(Agreed().OnYawRates(kSpeed_mps, 0.1, Doppler(0.45), Gyroscope(0.0)))
      << "at the origin";
}

// A mount that is off turns Doppler's motion with the speed, and does not contradict.
TEST(SingleRadarYawRateTest, LearnsWhereTheRadarLooks) {
  const double angle_rad = 10.0 * kRadPerDeg;
  SingleRadarYawRate yaw_rate = Agreed(angle_rad);
  for (const double speed_mps : {0.5, 5.0, 15.0}) {
    const ScalarEstimate seen = Doppler(0.1, angle_rad, 0.0, speed_mps);
    const auto reading = yaw_rate.OnYawRates(speed_mps, kAhead_m, seen, Gyroscope(0.1));
    EXPECT_EQ(reading->beyond_gyroscope_radps, 0.0) << speed_mps;
    EXPECT_NEAR(reading->yaw_rate.value, 0.1, 1e-9) << speed_mps;
  }
}

TEST(SingleRadarYawRateTest, ARadarThatWasKnockedIsLearnedAnew) {
  SingleRadarYawRate yaw_rate = Agreed();
  const ScalarEstimate seen = Doppler(0.0, 10.0 * kRadPerDeg);
  EXPECT_GT(Beyond(yaw_rate, seen, 0.0), 0.1);
  yaw_rate.OnMountChanged();
  for (int scan = 0; scan < 20; ++scan) {
    EXPECT_FALSE(yaw_rate.OnYawRates(kSpeed_mps, kAhead_m, seen, Gyroscope(0.0)));
  }
  EXPECT_EQ(Beyond(yaw_rate, seen, 0.0), 0.0);
}

// In a long corner a turn beside a dead gyroscope looks like a radar that looks aside.
TEST(SingleRadarYawRateTest, BesideAGyroscopeThatIsNotSoundNothingIsLearned) {
  SingleRadarYawRate yaw_rate;
  for (int scan = 0; scan < 40; ++scan) {
    EXPECT_FALSE(yaw_rate.OnYawRates(kSpeed_mps, kAhead_m, Doppler(0.45),
                                     {.yaw_rate_radps = 0.0, .is_sound = false}));
  }
}

}  // namespace
}  // namespace dcloc
