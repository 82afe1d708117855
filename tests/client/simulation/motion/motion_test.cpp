#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "client/simulation/motion/ego_motion.h"
#include "client/simulation/motion/speed_profile.h"
#include "client/simulation/motion/traffic.h"
#include "client/simulation/world/steps.h"

namespace dcloc::simulation {
namespace {

Path Route() {
  Path path;
  path.Append(150.0, 0.0);
  path.AppendBend(1.5, 18.0, 12.0);
  path.Append(120.0, 0.0);
  path.AppendBend(-0.4, 90.0, 25.0);
  path.Append(300.0, 0.0);
  return path;
}

SpeedProfileOptions PaceOf(double mean_mps) {
  SpeedProfileOptions options;
  options.begin_m = 20.0;
  options.end_m = 520.0;
  options.mean_speed_mps = mean_mps;
  return options;
}

EgoMotion MakeEgo(const Path& path, std::uint64_t seed) {
  Random random = MakeRandom(seed, Stream::kSpeed);
  const SpeedProfile profile = MakeSpeedProfile(path, PaceOf(12.0), random);
  return {path, profile, LaneKeeping(-1.7, random)};
}

TEST(SpeedProfileTest, SpeedIsTheDerivativeOfPosition) {
  const Path path = Route();
  Random random = MakeRandom(1, Stream::kSpeed);
  const SpeedProfile profile = MakeSpeedProfile(path, PaceOf(12.0), random);
  for (const double t : Steps(0.0051, profile.duration_s(), 0.173)) {
    const double rate = (profile.At(t + 1e-5).s_m - profile.At(t - 1e-5).s_m) / 2e-5;
    EXPECT_NEAR(rate, profile.At(t).speed_mps, 1e-6) << t;
  }
}

TEST(SpeedProfileTest, KeepsItsMeanAndTheLimitsOfADriver) {
  const Path path = Route();
  for (const double mean : {6.0, 11.0}) {
    Random random = MakeRandom(2, Stream::kSpeed);
    const SpeedProfile profile = MakeSpeedProfile(path, PaceOf(mean), random);
    EXPECT_NEAR(500.0 / profile.duration_s(), mean, 0.02 * mean);
    for (const double t : Steps(0.0, profile.duration_s(), 0.1)) {
      const double acceleration = (profile.At(t + 0.1).speed_mps - profile.At(t).speed_mps) / 0.1;
      EXPECT_LT(acceleration, 2.7);
      EXPECT_GT(acceleration, -3.2);
      const SpeedProfile::State state = profile.At(t);
      EXPECT_LT(state.speed_mps * state.speed_mps * std::abs(path.At(state.s_m).curvature_per_m),
                3.6);
    }
  }
}

TEST(SpeedProfileTest, AMeanThatBendsForbidStaysBelow) {
  Random random = MakeRandom(2, Stream::kSpeed);
  const SpeedProfile profile = MakeSpeedProfile(Route(), PaceOf(40.0), random);
  EXPECT_LT(500.0 / profile.duration_s(), 35.0);
  EXPECT_GT(500.0 / profile.duration_s(), 10.0);
}

TEST(SpeedProfileTest, HaltsWhereItIsTold) {
  SpeedProfileOptions options = PaceOf(8.0);
  options.stops_m = {140.0};
  Random random = MakeRandom(3, Stream::kSpeed);
  const SpeedProfile profile = MakeSpeedProfile(Route(), options, random);
  double standing_s = 0.0;
  double standing_at_m = 0.0;
  for (const double t : Steps(0.0, profile.duration_s(), 0.02)) {
    if (profile.At(t).speed_mps > 0.0) continue;
    standing_s += 0.02;
    standing_at_m = profile.At(t).s_m;
  }
  EXPECT_GT(standing_s, 1.0);
  EXPECT_NEAR(standing_at_m, 140.0, 2.0);
}

// Truth is only useful when velocities and poses are the same motion.
TEST(EgoMotionTest, DoesNotSlipSideways) {
  const Path path = Route();
  const EgoMotion ego = MakeEgo(path, 4);
  constexpr double kStep = 1e-4;
  for (const double t : Steps(0.0, ego.duration_s(), 0.093)) {
    const MotionState state = ego.At(t);
    const Eigen::Vector3d twist =
        Log(ego.At(t - kStep).T_map_vehicle.Inverse() * ego.At(t + kStep).T_map_vehicle) /
        (2.0 * kStep);
    EXPECT_NEAR(twist.x(), state.speed_mps, 1e-4) << t;
    EXPECT_NEAR(twist.y(), 0.0, 1e-6) << t;
    EXPECT_NEAR(twist.z(), state.yaw_rate_radps, 1e-5) << t;
  }
}

TEST(EgoMotionTest, VelocitiesIntegrateToThePoses) {
  const Path path = Route();
  const EgoMotion ego = MakeEgo(path, 5);
  constexpr double kStep = 0.002;
  Pose2 integrated = ego.At(0.0).T_map_vehicle;
  for (const double t : Steps(0.0, 40.0, kStep)) {
    const MotionState middle = ego.At(t + 0.5 * kStep);
    integrated = integrated *
                 Exp(Eigen::Vector3d(kStep * middle.speed_mps, 0.0, kStep * middle.yaw_rate_radps));
  }
  const Eigen::Vector3d error = Log(ego.At(40.0).T_map_vehicle.Inverse() * integrated);
  EXPECT_LT(error.head<2>().norm(), 1e-3);
  EXPECT_LT(std::abs(error.z()), 1e-5);
}

TEST(TrafficTest, VehiclesMoveAsTheirVelocitiesSay) {
  const World world = MakeTown(7, 600.0);
  Random random = MakeRandom(7, Stream::kTraffic);
  Random speed_random = MakeRandom(7, Stream::kSpeed);
  SpeedProfileOptions options = PaceOf(10.0);
  options.begin_m = world.drive_begin_m;
  options.end_m = world.drive_begin_m + world.length_m;
  const EgoMotion ego(world.route, MakeSpeedProfile(world.route, options, speed_random),
                      LaneKeeping(-1.75));
  const Traffic traffic(world, ego, -1.75, 10.0, random);
  constexpr double kStep = 1e-4;
  int compared = 0;
  for (const double t : Steps(1.0, ego.duration_s(), 3.1)) {
    for (const MovingBody& body : traffic.At(t, 150.0)) {
      const std::vector<MovingBody> later = traffic.At(t + kStep, 150.0);
      const auto same = std::find_if(later.begin(), later.end(), [&](const MovingBody& other) {
        return other.vehicle == body.vehicle;
      });
      if (same == later.end()) continue;
      const Eigen::Vector2d moved = same->T_map_body.translation_m - body.T_map_body.translation_m;
      if (moved.norm() > 1.0) continue;  // it left the world and came in again at the other end
      EXPECT_LT((moved / kStep - body.velocity_mps).norm(), 0.01);
      // It drives ahead: no body moves sideways.
      EXPECT_NEAR((body.T_map_body.Inverse().Rotation() * body.velocity_mps).y(), 0.0, 1e-6);
      ++compared;
    }
  }
  EXPECT_GT(compared, 50);
}

}  // namespace
}  // namespace dcloc::simulation
