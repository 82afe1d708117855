#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "client/simulation/radar/ghosts.h"
#include "client/simulation/radar/scan_simulator.h"
#include "client/simulation/world/steps.h"

namespace dcloc::simulation {
namespace {

// A quiet radar, so that what is measured is what is there.
ScanSimulatorOptions Noiseless() {
  ScanSimulatorOptions options;
  options.profile = CarlaProfile(NoiseKind::kGaussian);
  options.profile.range_m.scale = 0.0;
  options.profile.azimuth_rad.scale = 0.0;
  options.profile.elevation_rad.scale = 0.0;
  options.profile.range_rate_mps.scale = 0.0;
  options.clutter_share = 0.0;
  options.ghost_share = 0.0;
  return options;
}

RadarModel FrontRadar(double beta_s) {
  return MakeRig(CarlaProfile(NoiseKind::kGaussian), 1, beta_s, true, 0.0).radars[0];
}

World PoleAt(double x, double y, double z) {
  World world;
  Scatterer pole;
  pole.position_m = {x, y, z};
  pole.rcs_dbsm = 20.0;
  pole.id = 5;
  world.scatterers.push_back(pole);
  return world;
}

SimulatedScan Look(const World& world, const MotionState& motion, const RadarModel& radar,
                   const ScanSimulatorOptions& options) {
  Random random = MakeRandom(1, Stream::kScan);
  return SimulateScan(Scene(world, {}), {}, motion, radar, options, random);
}

TEST(RadarViewTest, RangeRateIsTheDerivativeOfRange) {
  // Along a bend, for a radar off the axle and looking aside, with a moving target.
  Path path;
  path.Append(10.0, 0.05);
  path.Append(60.0, 0.05);
  const EgoMotion ego(path, SpeedProfile::Constant(12.0, 9.0), LaneKeeping(-1.5));
  const Pose3 T_vehicle_radar =
      MakeRig(Ars408Profile(), 2, 0.0, false, 0.0).radars[1].T_vehicle_radar;
  const Eigen::Vector3d velocity(-3.0, 5.0, 0.0);
  const auto observe = [&](double t) {
    return ViewFrom(ego.At(t), T_vehicle_radar)
        .Observe(Eigen::Vector3d(31.0, 14.0, 2.0) + t * velocity, velocity);
  };
  for (const double t : Steps(0.1, 4.0, 0.3)) {
    const double derivative = (observe(t + 1e-5).range_m - observe(t - 1e-5).range_m) / 2e-5;
    EXPECT_NEAR(observe(t).range_rate_mps, derivative, 1e-6) << t;
  }
}

TEST(RadarViewTest, AnglesPointAtTheTarget) {
  MotionState motion;
  motion.T_map_vehicle = {{3.0, -4.0}, 0.7};
  const RadarModel radar = FrontRadar(0.0);
  const RadarView view = ViewFrom(motion, radar.T_vehicle_radar);
  const Eigen::Vector3d p_map(25.0, 18.0, 6.0);
  const Observation seen = view.Observe(p_map, Eigen::Vector3d::Zero());
  const Eigen::Vector3d p_radar(
      seen.range_m * std::cos(seen.elevation_rad) * std::cos(seen.azimuth_rad),
      seen.range_m * std::cos(seen.elevation_rad) * std::sin(seen.azimuth_rad),
      seen.range_m * std::sin(seen.elevation_rad));
  EXPECT_LT((view.T_map_radar * p_radar - p_map).norm(), 1e-9);
}

TEST(ScanSimulatorTest, AnApproachingTargetIsMeasuredTooNear) {
  MotionState motion;
  motion.speed_mps = 10.0;
  const RadarModel radar = FrontRadar(0.04);
  const SimulatedScan seen = Look(PoleAt(43.41, 0.0, 0.5), motion, radar, Noiseless());
  ASSERT_EQ(seen.scan.size(), 1U);
  EXPECT_NEAR(seen.scan.range_rate_mps[0], -10.0, 1e-5);
  EXPECT_NEAR(seen.scan.range_m[0], 40.0 - 0.04 * 10.0, 1e-4);
  EXPECT_NEAR(seen.scan.azimuth_rad[0], 0.0, 1e-6);
  // Receding, it is measured too far.
  motion.speed_mps = -10.0;
  const SimulatedScan receding = Look(PoleAt(43.41, 0.0, 0.5), motion, radar, Noiseless());
  ASSERT_EQ(receding.scan.size(), 1U);
  EXPECT_NEAR(receding.scan.range_m[0], 40.4, 1e-4);
}

TEST(ScanSimulatorTest, FoldsAndQuantisesRangeRatesButCouplesTheTrueOne) {
  MotionState motion;
  motion.speed_mps = 33.1;
  RadarModel radar = FrontRadar(0.04);
  radar.unambiguous_range_rate_mps = 20.0;
  ScanSimulatorOptions options = Noiseless();
  options.range_rate_step_mps = 0.25;
  const SimulatedScan seen = Look(PoleAt(43.41, 0.0, 0.5), motion, radar, options);
  ASSERT_EQ(seen.scan.size(), 1U);
  EXPECT_NEAR(seen.scan.range_rate_mps[0], -33.0 + 40.0, 1e-5);
  EXPECT_NEAR(seen.scan.range_m[0], 40.0 - 0.04 * 33.1, 1e-4);
}

TEST(ScanSimulatorTest, MeasuresElevationOnlyWhereTheRadarDoes) {
  RadarModel radar = FrontRadar(0.0);
  const World world = PoleAt(43.41, 0.0, 5.5);
  const SimulatedScan high = Look(world, {}, radar, Noiseless());
  ASSERT_EQ(high.scan.elevation_rad.size(), 1U);
  EXPECT_NEAR(high.scan.elevation_rad[0], std::atan2(5.0, 40.0), 1e-6);
  radar.has_elevation = false;
  const SimulatedScan planar = Look(world, {}, radar, Noiseless());
  EXPECT_TRUE(planar.scan.elevation_rad.empty());
  ASSERT_EQ(planar.scan.size(), 1U);
  EXPECT_NEAR(planar.scan.range_m[0], std::hypot(5.0, 40.0), 1e-4);
}

TEST(ScanSimulatorTest, AFlatWorldHasNoSlantRanges) {
  const RadarModel radar = FrontRadar(0.0);
  const double up_m = 4.0;
  const World world = PoleAt(40.0 + radar.T_vehicle_radar.translation_m.x(), 0.0,
                             radar.T_vehicle_radar.translation_m.z() + up_m);
  MotionState motion;
  motion.speed_mps = 20.0;
  ScanSimulatorOptions options = Noiseless();
  const Scan slant = Look(world, motion, radar, options).scan;
  options.is_flat = true;
  const Scan flat = Look(world, motion, radar, options).scan;
  ASSERT_EQ(slant.size(), 1U);
  ASSERT_EQ(flat.size(), 1U);
  EXPECT_NEAR(slant.range_m[0], std::hypot(40.0, up_m), 1e-4);
  EXPECT_NEAR(flat.range_m[0], 40.0, 1e-4);
  EXPECT_NEAR(flat.range_rate_mps[0], -20.0, 1e-4);
  EXPECT_EQ(flat.elevation_rad[0], 0.0F);
}

TEST(ScanSimulatorTest, SeesOnlyItsField) {
  const RadarModel radar = FrontRadar(0.0);
  EXPECT_EQ(Look(PoleAt(-30.0, 0.0, 0.5), {}, radar, Noiseless()).scan.size(), 0U);
  EXPECT_EQ(Look(PoleAt(104.0, 0.0, 0.5), {}, radar, Noiseless()).scan.size(), 0U);
  EXPECT_EQ(Look(PoleAt(13.41, 30.0, 0.5), {}, radar, Noiseless()).scan.size(), 1U);  // 72 degrees
  EXPECT_EQ(Look(PoleAt(7.41, 30.0, 0.5), {}, radar, Noiseless()).scan.size(), 0U);   // 82 degrees
}

TEST(ScanSimulatorTest, AWallHidesWhatIsBehindAndLower) {
  World world = PoleAt(43.41, 0.0, 2.0);
  world.walls.push_back({{20.0, -5.0}, {20.0, 5.0}, 4.0, kOpaqueDb, false});
  const RadarModel radar = FrontRadar(0.0);
  EXPECT_EQ(Look(world, {}, radar, Noiseless()).scan.size(), 0U);
  world.walls[0].height_m = 0.9;  // the ray passes over it
  EXPECT_EQ(Look(world, {}, radar, Noiseless()).scan.size(), 1U);
  world.walls[0] = {{20.0, 1.0}, {20.0, 5.0}, 4.0, kOpaqueDb, false};  // and beside it
  EXPECT_EQ(Look(world, {}, radar, Noiseless()).scan.size(), 1U);
}

TEST(ScanSimulatorTest, AVehicleHidesPartly) {
  Random random = MakeRandom(3, Stream::kParking);
  const Vehicle car = MakeVehicle(random, 0.0);
  const World world = PoleAt(43.41, 0.0, 0.5);
  const RadarView view = ViewFrom({}, FrontRadar(0.0).T_vehicle_radar);
  const MovingBody body{&car, {{20.0, 0.0}, 0.3}, Eigen::Vector2d::Zero(), 0.0};
  const Occlusion occlusion =
      CollectOcclusion(Scene(world, {}), {body}, view, CarlaProfile(NoiseKind::kGaussian));
  const double behind = occlusion.LossDb({43.41, 0.0, 0.5}, 0.3);
  EXPECT_GT(behind, 3.0);
  EXPECT_LT(behind, kOpaqueDb);
  EXPECT_EQ(occlusion.LossDb({43.41, 12.0, 0.5}, 0.3), 0.0);
  EXPECT_EQ(occlusion.LossDb({15.0, 0.0, 0.5}, 0.3), 0.0);
}

TEST(OcclusionTest, AgreesWithTestingEveryWall) {
  Random random = MakeRandom(9, Stream::kScan);
  const Eigen::Vector3d eye(1.0, -2.0, 0.5);
  Occlusion occlusion(eye);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector2d begin(Uniform(random, -60.0, 60.0), Uniform(random, -60.0, 60.0));
    const Eigen::Vector2d end =
        begin + Eigen::Vector2d(Uniform(random, -9.0, 9.0), Uniform(random, -9.0, 9.0));
    occlusion.Add({begin, end, 3.0, 1.0, false});
  }
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d target(Uniform(random, -60.0, 60.0), Uniform(random, -60.0, 60.0), 0.5);
    int crossed = 0;
    for (const Wall& wall : occlusion.walls()) {
      if (CrossingShare(eye.head<2>(), target.head<2>(), wall) > 0.0) ++crossed;
    }
    EXPECT_EQ(occlusion.LossDb(target, 0.0), crossed);
  }
}

TEST(EchoTest, AScattererIsSeenFromItsSectorOnly) {
  Scatterer plate;
  plate.rcs_dbsm = 10.0;
  plate.facing_rad = 3.0;
  plate.half_sector_rad = 0.5;
  plate.id = 17;
  EXPECT_TRUE(std::isfinite(AspectRcsDbsm(plate, 3.4)));
  EXPECT_TRUE(std::isfinite(AspectRcsDbsm(plate, 2.6)));
  EXPECT_TRUE(std::isinf(AspectRcsDbsm(plate, 3.0 + 0.6 - 2.0 * std::numbers::pi)));
  EXPECT_TRUE(std::isinf(AspectRcsDbsm(plate, 0.0)));
  EXPECT_LT(AspectRcsDbsm(plate, 3.499), 0.0);  // the taper at the edge
}

TEST(EchoTest, PowerFallsWithTheFourthPowerOfRange) {
  const RadarProfile profile = Ars408Profile();
  const double near = BeamGainDb(profile, {20.0, 0.3, 0.0, 0.0});
  EXPECT_NEAR(near - BeamGainDb(profile, {40.0, 0.3, 0.0, 0.0}), 40.0 * std::log10(2.0), 1e-9);
  EXPECT_TRUE(std::isinf(BeamGainDb(profile, {120.0, 0.3, 0.0, 0.0})));
  EXPECT_TRUE(std::isfinite(BeamGainDb(profile, {200.0, 0.05, 0.0, 0.0})));
  EXPECT_TRUE(std::isinf(BeamGainDb(profile, {20.0, 1.1, 0.0, 0.0})));
}

// The mirror's law: the ghost's range is the bounced path's, and its range rate that path's change.
TEST(GhostTest, AMirrorGhostHasTheBouncedPathsRangeAndRate) {
  const Wall wall{{0.0, 6.0}, {60.0, 6.0}, 8.0, kOpaqueDb, true};
  const Eigen::Vector3d target_velocity(-8.0, 1.0, 0.0);
  const auto ghost_at = [&](double t) {
    RadarView view;
    view.T_map_radar.translation_m = {10.0 * t, 0.0, 0.5};
    view.velocity_mps = {10.0, 0.0, 0.0};
    Occlusion occlusion(view.T_map_radar.translation_m);
    occlusion.Add(wall);
    Echo echo;
    echo.source = EchoSource::kMoving;
    echo.p_map = Eigen::Vector3d(40.0, 2.0, 0.5) + t * target_velocity;
    echo.velocity_map_mps = target_velocity;
    echo.observation = view.Observe(echo.p_map, target_velocity);
    echo.rcs_dbsm = 20.0;
    echo.snr_db = 30.0;
    return CollectGhosts({echo}, occlusion, view, CarlaProfile(NoiseKind::kGaussian));
  };
  const std::vector<Echo> ghosts = ghost_at(0.0);
  ASSERT_EQ(ghosts.size(), 1U);
  EXPECT_EQ(ghosts[0].source, EchoSource::kMirror);
  EXPECT_NEAR(ghosts[0].p_map.y(), 10.0, 1e-12);
  EXPECT_NEAR(ghosts[0].observation.range_m, std::hypot(40.0, 10.0), 1e-9);
  const double rate =
      (ghost_at(1e-5)[0].observation.range_m - ghost_at(-1e-5)[0].observation.range_m) / 2e-5;
  EXPECT_NEAR(ghosts[0].observation.range_rate_mps, rate, 1e-5);
}

}  // namespace
}  // namespace dcloc::simulation
