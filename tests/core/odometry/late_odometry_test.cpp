#include "core/odometry/late_odometry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/odometry/motion.h"

namespace dcloc {
namespace {

EgoVelocity Weaving(double t_s) {
  EgoVelocity velocity;
  velocity.linear_mps.x() = 12.0 + 3.0 * std::sin(0.8 * t_s);
  velocity.angular_radps.z() = 0.15 * std::sin(0.5 * t_s);
  return WithCovariance(velocity, 0.01, {});
}

constexpr double kStep_s = 0.075;
constexpr std::chrono::nanoseconds kStep = std::chrono::milliseconds(75);
constexpr OdometrySources kAllSources(0b111);
constexpr OdometrySources kWheelSpeedAlone(1U
                                           << static_cast<unsigned>(OdometrySource::kWheelSpeed));

struct Ways {
  Pose3 true_way;
  Pose3 brought;   // the sum of T_previous_now
  Pose3 reported;  // the sum of what is late
  int step_count = 0;
};

// After a minute in which the delay is learned, a way of half a minute.
Ways WaysOf(double delay_s) {
  LateOdometry late({});
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  Ways ways;
  for (int i = 0; i < 1200; ++i) {
    const double t_s = kStep_s * i;
    const Stamp stamp{i * kStep};
    EgoVelocity reported = Weaving(t_s - delay_s);
    EgoVelocity doppler = Weaving(t_s);
    doppler.linear_mps.x() += 0.05 * normal(random);
    doppler.angular_radps.z() += 0.01 + 0.015 * normal(random);
    late.OnReported(stamp, reported);
    late.OnDoppler(stamp, doppler);
    late.ExtrapolatedToNow(stamp, reported, &doppler, kAllSources);
    if (i < 800) continue;
    const auto way = [&](double from_s, double to_s) {
      return Integrate(Weaving(from_s), Weaving(to_s), kStep, {}).T_from_to;
    };
    ways.true_way = ways.true_way * way(t_s - kStep_s, t_s);
    ways.reported = ways.reported * way(t_s - kStep_s - delay_s, t_s - delay_s);
    if (!late.T_previous_now()) continue;
    ways.brought = ways.brought * *late.T_previous_now();
    ++ways.step_count;
  }
  return ways;
}

double YawOf(const Pose3& pose) { return Flatten(pose).yaw_rad; }

TEST(LateOdometryTest, ErrorsOfWhatIsBroughtToNowDoNotAddUp) {
  for (const double delay_s : {0.1, 0.3}) {
    const Ways ways = WaysOf(delay_s);
    ASSERT_EQ(ways.step_count, 400);
    const double yaw_error = std::abs(WrapAngle(YawOf(ways.brought) - YawOf(ways.true_way)));
    EXPECT_LT(yaw_error, 0.05 * delay_s);
    const Pose3 error = ways.true_way.Inverse() * ways.brought;
    EXPECT_LT(error.translation_m.norm(), 3.0 * delay_s);
  }
}

TEST(LateOdometryTest, WithoutADelayItLeavesTheMotionAlone) {
  EXPECT_EQ(WaysOf(0.0).step_count, 0);
}

TEST(LateOdometryTest, AMotionNeedsBothSignals) {
  LateOdometry late({});
  late.Restore({0.2, 1e-4});
  ASSERT_TRUE(late.delay_s());
  const EgoVelocity reported = Weaving(0.0);
  for (int i = 0; i < 3; ++i) {
    late.ExtrapolatedToNow(Stamp{i * kStep}, reported, nullptr, kAllSources);
  }
  EXPECT_TRUE(late.T_previous_now());
  late.ExtrapolatedToNow(Stamp{3 * kStep}, reported, nullptr, kWheelSpeedAlone);
  EXPECT_FALSE(late.T_previous_now());
  late.ExtrapolatedToNow(Stamp{4 * kStep}, reported, nullptr, kAllSources);
  EXPECT_FALSE(late.T_previous_now()) << "the one before was not brought to now";
}

}  // namespace
}  // namespace dcloc
