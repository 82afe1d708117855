#include "core/odometry/ego_motion.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/geometry/covariance.h"
#include "tests/core/radar/scan_fixture.h"

namespace dcloc {
namespace {

const RadarModel kRadar = RadarAt("front", 3.5, 0.0, 0.0);

EgoVelocity Planar(double speed_mps, double yaw_rate_radps) {
  return {.linear_mps = {speed_mps, 0.0, 0.0}, .angular_radps = {0.0, 0.0, yaw_rate_radps}};
}

Stamp At(int ms) { return Stamp(std::chrono::milliseconds(5'000'000 + ms)); }

Scan Empty(int ms) { return {.stamp = At(ms), .radar_id = "front"}; }

Scan Seen(int ms, const EgoVelocity& ego) {
  Scan scan = StaticScan(kRadar, ego, 80, static_cast<unsigned>(ms), 1.0);
  scan.stamp = At(ms);
  return scan;
}

Vector6d Twist(const EgoVelocity& velocity) {
  Vector6d twist;
  twist << velocity.linear_mps, velocity.angular_radps;
  return twist;
}

TEST(EgoMotionTest, WheelsAloneAreTakenAsTheyAre) {
  EgoMotion motion;
  Scan scan = Empty(0);
  scan.ego_velocity = Planar(12.0, 0.2);
  const EgoVelocity velocity = motion.Advance(scan, kRadar);
  EXPECT_EQ(velocity.linear_mps, scan.ego_velocity->linear_mps);
  EXPECT_EQ(velocity.angular_radps, scan.ego_velocity->angular_radps);
  ASSERT_TRUE(velocity.covariance.has_value());
  EXPECT_GT(velocity.covariance->diagonal().minCoeff(), 0.0);
  // The first scan has nothing before it.
  EXPECT_LT(Log(motion.since_previous().T_from_to).norm(), 1e-15);
  EXPECT_EQ(motion.since_previous().covariance, Matrix6d::Zero());
}

TEST(EgoMotionTest, TicksTellHowTheVehicleMovedBetweenTwoScans) {
  EgoMotion motion;
  Scan scan = Empty(0);
  scan.ego_velocity = Planar(10.0, 0.0);
  motion.Advance(scan, kRadar);
  scan.stamp = At(400);
  scan.ticks = {{std::chrono::milliseconds(-400), 10.0, 0.0},
                {std::chrono::milliseconds(-200), 6.0, 0.0},
                {std::chrono::milliseconds(0), 10.0, 0.0}};
  motion.Advance(scan, kRadar);
  EXPECT_NEAR(motion.since_previous().T_from_to.translation_m.x(), 3.2, 1e-9);
}

TEST(EgoMotionTest, DopplerAloneFindsTheMotion) {
  EgoMotion motion;
  const EgoVelocity velocity = motion.Advance(Seen(0, Planar(12.0, 0.1)), kRadar);
  EXPECT_NEAR(velocity.linear_mps.x(), 12.0, 0.1);
  EXPECT_NEAR(velocity.angular_radps.z(), 0.1, 0.03);
}

TEST(EgoMotionTest, BothAreFusedByTheirInformation) {
  EgoMotion motion;
  Scan scan = Seen(0, Planar(12.0, 0.1));
  EgoVelocity wheels = Planar(12.3, 0.09);
  wheels.covariance = EmbedCovariance(Eigen::Vector3d(0.09, 0.04, 1e-4).asDiagonal(), 1e-4, 1e-4);
  scan.ego_velocity = wheels;
  const EgoVelocity fused = motion.Advance(scan, kRadar);

  // The Doppler part alone, from a vehicle without wheels.
  EgoMotion without;
  const EgoVelocity doppler = without.Advance(Seen(0, Planar(12.0, 0.1)), kRadar);
  const Matrix6d information = wheels.covariance->inverse() + doppler.covariance->inverse();
  const Vector6d mean = information.inverse() * (wheels.covariance->inverse() * Twist(wheels) +
                                                 doppler.covariance->inverse() * Twist(doppler));
  EXPECT_LT((Twist(fused) - mean).norm(), 1e-9);
  EXPECT_LT((*fused.covariance - information.inverse()).norm(), 1e-3) << "they hardly differ";
  EXPECT_LT((*fused.covariance)(0, 0), (*wheels.covariance)(0, 0));
}

// A drive at 20 m/s of which the radar, or the wheels, say otherwise in the end.
double SpeedAfter(double doppler_mps, double wheels_mps) {
  EgoMotion motion;
  for (int i = 0; i < 20; ++i) {
    Scan scan = Seen(77 * i, Planar(20.0, 0.0));
    scan.ego_velocity = Planar(20.0, 0.0);
    motion.Advance(scan, kRadar);
  }
  double speed_mps = 0.0;
  for (int i = 20; i < 24; ++i) {
    Scan scan = Seen(77 * i, Planar(doppler_mps, 0.0));
    scan.ego_velocity = Planar(wheels_mps, 0.0);
    speed_mps = motion.Advance(scan, kRadar).linear_mps.x();
  }
  return speed_mps;
}

TEST(EgoMotionTest, WhatDepartsFromTheOthersIsLeftOut) {
  EXPECT_NEAR(SpeedAfter(20.0, 20.0), 20.0, 0.1);
  EXPECT_NEAR(SpeedAfter(2.0, 20.0), 20.0, 0.1) << "a lorry that fills the view";
  EXPECT_NEAR(SpeedAfter(20.0, 0.0), 20.0, 0.3) << "wheels that stand";
}

TEST(EgoMotionTest, WheelsThatAreSuddenlyAFewPerCentOffAreFollowed) {
  for (const double factor : {0.95, 1.05}) {
    EgoMotion motion;
    const auto speed_after = [&](int begin_ms, int end_ms, double of_wheels) {
      double speed_mps = 0.0;
      for (int ms = begin_ms; ms < end_ms; ms += 75) {
        Scan scan = Seen(ms, Planar(12.0, 0.0));
        scan.ego_velocity = Planar(of_wheels * 12.0, 0.0);
        speed_mps = motion.Advance(scan, kRadar).linear_mps.x();
      }
      return speed_mps;
    };
    EXPECT_NEAR(speed_after(0, 15'000, 1.0), 12.0, 0.05);
    EXPECT_NEAR(speed_after(15'000, 18'000, factor), 12.0, 0.15) << factor;
  }
}

TEST(EgoMotionTest, WheelsThatLeapAreNotFollowedBeforeItIsKnownWhy) {
  EgoMotion motion;
  double farthest_mps = 0.0;
  for (int ms = 0; ms < 18'000; ms += 75) {
    Scan scan = Seen(ms, Planar(25.0, 0.0));
    scan.ego_velocity = Planar(ms < 15'000 ? 25.0 : 0.95 * 25.0, 0.0);
    const double speed_mps = motion.Advance(scan, kRadar).linear_mps.x();
    if (ms >= 15'000) farthest_mps = std::max(farthest_mps, std::abs(speed_mps - 25.0));
  }
  EXPECT_LT(farthest_mps, 0.3) << "wheels alone would be off by 1.25";
}

// A vehicle that speeds up and slows down on a highway, with wheels that are late: a scale would be
// learned of no registration here, only of Doppler.
TEST(EgoMotionTest, LateWheelsTeachNoScale) {
  const auto velocity = [](double t_s) { return Planar(27.0 + 3.0 * std::sin(0.5 * t_s), 0.0); };
  EgoMotion motion;
  for (int ms = 0; ms < 60'000; ms += 75) {
    Scan scan = Seen(ms, velocity(1e-3 * ms));
    scan.ego_velocity = velocity(1e-3 * ms - 0.25);
    const double speed_mps = motion.Advance(scan, kRadar).linear_mps.x();
    if (ms < 15'000) continue;
    EXPECT_NEAR(speed_mps, velocity(1e-3 * ms).linear_mps.x(), 0.35) << ms;
  }
}

// A vehicle that weaves, with wheels that are `delay_s` late: the root mean square error of its
// speed in the last 20 of 45 seconds.
double SpeedErrorOf(double delay_s, const LateOdometryOptions& late) {
  const auto velocity = [](double t_s) {
    return Planar(12.0 + 3.0 * std::sin(0.8 * t_s), 0.15 * std::sin(0.5 * t_s));
  };
  EgoMotion motion({.late = late});
  double sum = 0.0;
  int count = 0;
  for (int ms = 0; ms < 45'000; ms += 75) {
    Scan scan = Seen(ms, velocity(1e-3 * ms));
    scan.ego_velocity = velocity(1e-3 * ms - delay_s);
    const double speed_mps = motion.Advance(scan, kRadar).linear_mps.x();
    if (ms < 25'000) continue;
    sum += std::pow(speed_mps - velocity(1e-3 * ms).linear_mps.x(), 2);
    ++count;
  }
  RigKnowledge known;
  motion.AddTo(known);
  if (delay_s > 0.0 && known.odometry_delay) {
    EXPECT_EQ(motion.wheel_speed().fault, SourceFault::kDelay);
  }
  return std::sqrt(sum / count);
}

TEST(EgoMotionTest, ALateVelocityIsBroughtToThePresent) {
  LateOdometryOptions as_before;
  as_before.delay.min_log_likelihood = 1e9;
  EXPECT_LT(SpeedErrorOf(0.2, {}), 0.4 * SpeedErrorOf(0.2, as_before));
  EXPECT_EQ(SpeedErrorOf(0.0, {}), SpeedErrorOf(0.0, as_before)) << "what is not late is untouched";
}

// A convoy on both sides takes two thirds of the targets; the ground has the rest.
Scan InConvoy(int ms, const EgoVelocity& ego) {
  Scan scan = Seen(ms, ego);
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (i % 3 != 0) scan.range_rate_mps[i] = 0.0F;
  }
  return scan;
}

TEST(EgoMotionTest, AConvoyOnBothSidesIsNotTheGround) {
  EgoMotion motion;
  for (int i = 0; i < 150; ++i) {
    Scan scan = i < 30 ? Seen(75 * i, Planar(15.0, 0.0)) : InConvoy(75 * i, Planar(15.0, 0.0));
    scan.ego_velocity = Planar(15.0, 0.0);
    EXPECT_NEAR(motion.Advance(scan, kRadar).linear_mps.x(), 15.0, 0.5) << i;
  }
  EXPECT_TRUE(motion.wheel_speed().is_used);
}

// By one radar: what it sees of a turn is what a mount that is off shows as well.
TEST(EgoMotionTest, AYawRateOfTheOtherSignIsFoundInACurve) {
  EgoMotion motion;
  for (int i = 0; i < 40; ++i) {
    const double yaw_rate_radps = 0.04 * std::max(0, i - 25);
    Scan scan = Seen(75 * i, Planar(12.0, yaw_rate_radps));
    const double sign = motion.yaw_rate_is_reversed() ? 1.0 : -1.0;
    scan.ego_velocity = Planar(12.0, sign * yaw_rate_radps);
    motion.Advance(scan, kRadar);
    if (i == 25) {
      EXPECT_FALSE(motion.yaw_rate_is_reversed());
    }
  }
  EXPECT_TRUE(motion.yaw_rate_is_reversed());
  EXPECT_EQ(motion.yaw_rate(), (SourceHealth{.is_used = true, .fault = SourceFault::kSign}));
}

// One radar alone cannot know that it was not knocked. So nobody knows how far the vehicle turns.
TEST(EgoMotionTest, ATurnThatTheGyroscopeMissesIsInDoubt) {
  EgoMotion motion;
  const auto advance = [&](int scan_number, double yaw_rate_radps) {
    Scan scan = Seen(77 * scan_number, Planar(5.0, yaw_rate_radps));
    scan.ego_velocity = Planar(5.0, 0.0);
    motion.Advance(scan, kRadar);
  };
  for (int i = 0; i < 40; ++i) advance(i, 0.0);
  EXPECT_LT(motion.turn_spread_rad(), 0.001);
  EXPECT_TRUE(motion.velocity_for_mounts().has_value());
  for (int i = 40; i < 46; ++i) advance(i, 0.08 * (i - 39));  // as a vehicle begins to turn
  EXPECT_GT(motion.turn_spread_rad(), 0.05) << "of the 0.13 that it is";
  EXPECT_FALSE(motion.velocity_for_mounts().has_value()) << "no mount is learned by it";
}

TEST(EgoMotionTest, TheLastVelocityIsHeldEverLessCertain) {
  EgoMotion motion;
  Scan scan = Empty(0);
  scan.ego_velocity = Planar(15.0, 0.1);
  EgoVelocity before = motion.Advance(scan, kRadar);
  for (int ms = 100; ms <= 2000; ms += 100) {
    const EgoVelocity held = motion.Advance(Empty(ms), kRadar);
    EXPECT_EQ(held.linear_mps, before.linear_mps);
    EXPECT_EQ(held.angular_radps, before.angular_radps);
    EXPECT_GT((*held.covariance)(0, 0), (*before.covariance)(0, 0));
    EXPECT_GT((*held.covariance)(5, 5), (*before.covariance)(5, 5));
    before = held;
  }
}

TEST(EgoMotionTest, ASilentStartKnowsNothingOfTheSpeed) {
  EgoMotion motion;
  const EgoVelocity velocity = motion.Advance(Empty(0), kRadar);
  EXPECT_EQ(velocity.linear_mps.norm(), 0.0);
  EXPECT_GT(std::sqrt((*velocity.covariance)(0, 0)), 5.0);
}

TEST(EgoMotionTest, MotionIsTheIntegralBetweenTheScans) {
  EgoMotion motion;
  Scan scan = Empty(0);
  scan.ego_velocity = Planar(10.0, 0.5);
  motion.Advance(scan, kRadar);
  scan.stamp = At(200);
  motion.Advance(scan, kRadar);
  Vector6d way;
  way << 2.0, 0.0, 0.0, 0.0, 0.0, 0.1;
  EXPECT_LT(Log(Exp(way).Inverse() * motion.since_previous().T_from_to).norm(), 1e-12);
  EXPECT_TRUE(IsCovariance(motion.since_previous().covariance));
  EXPECT_GT(motion.since_previous().covariance(0, 0), 0.0);
  // Another radar's scan of the same moment: no time, no motion.
  motion.Advance(scan, kRadar);
  EXPECT_LT(Log(motion.since_previous().T_from_to).norm(), 1e-15);
  EXPECT_EQ(motion.since_previous().covariance.norm(), 0.0);
}

TEST(EgoMotionTest, SimultaneousRadarsMeasureTheYawRateTogether) {
  // With a side slip, which one radar ahead cannot tell from turning.
  EgoVelocity ego = Planar(12.0, 0.2);
  ego.linear_mps.y() = 0.15;
  const RadarModel rear = RadarAt("rear", -1.0, 0.0, M_PI);
  EgoMotion motion;
  motion.Advance(Seen(0, ego), kRadar);
  Scan behind = StaticScan(rear, ego, 80, 9, 1.0);
  behind.stamp = At(10);
  const EgoVelocity both = motion.Advance(behind, rear);

  EgoMotion alone;
  const EgoVelocity one = alone.Advance(Seen(0, ego), kRadar);
  EXPECT_LT(std::abs(both.angular_radps.z() - 0.2), 0.5 * std::abs(one.angular_radps.z() - 0.2));
  EXPECT_NEAR(both.angular_radps.z(), 0.2, 0.03);

  // A scan of long ago says nothing about now.
  EgoMotion later;
  later.Advance(Seen(0, Planar(1.0, 0.0)), kRadar);
  Scan now = StaticScan(rear, Planar(12.0, 0.0), 80, 9, 1.0);
  now.stamp = At(1000);
  EXPECT_NEAR(later.Advance(now, rear).linear_mps.x(), 12.0, 0.1);
}

TEST(EgoMotionTest, TheSameScansGiveTheSameBits) {
  EgoMotion a;
  EgoMotion b;
  for (int ms = 0; ms < 500; ms += 50) {
    const Scan scan = Seen(ms, Planar(12.0, 0.1));
    const EgoVelocity first = a.Advance(scan, kRadar);
    const EgoVelocity second = b.Advance(scan, kRadar);
    EXPECT_EQ(Twist(first), Twist(second));
    EXPECT_EQ(*first.covariance, *second.covariance);
  }
}

}  // namespace
}  // namespace dcloc
