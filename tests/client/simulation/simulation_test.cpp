#include "client/simulation/simulation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <vector>

namespace dcloc {
namespace {

using simulation::Echo;
using simulation::EchoSource;
using ::testing::HasSubstr;

SimulationOptions Small(WorldKind world, RadarKind radar) {
  SimulationOptions options;
  options.world = world;
  options.radar = radar;
  options.seed = 21;
  options.length_m = 200.0;
  return options;
}

SimulatedPass PassOf(const SimulationOptions& options, std::size_t pass) {
  auto simulated = SimulatePassWithTruth(MakeWorld(options), options, Passes(options)[pass]);
  EXPECT_TRUE(simulated.ok()) << simulated.status();
  return *std::move(simulated);
}

TEST(SimulationTest, EqualOptionsGiveEqualScans) {
  const SimulationOptions options = Small(WorldKind::kTown, RadarKind::kArs408);
  SimulationOptions other = options;
  other.seed = 22;
  const SimulatedPass first = PassOf(options, 0);
  const SimulatedPass second = PassOf(options, 0);
  const SimulatedPass third = PassOf(other, 0);
  ASSERT_EQ(first.drive.scans.size(), second.drive.scans.size());
  for (std::size_t i = 0; i < first.drive.scans.size(); ++i) {
    const Scan& a = first.drive.scans[i].scan;
    const Scan& b = second.drive.scans[i].scan;
    EXPECT_EQ(a.stamp, b.stamp);
    EXPECT_EQ(a.range_m, b.range_m);
    EXPECT_EQ(a.azimuth_rad, b.azimuth_rad);
    EXPECT_EQ(a.range_rate_mps, b.range_rate_mps);
    EXPECT_EQ(a.rcs_dbsm, b.rcs_dbsm);
    EXPECT_EQ(a.ego_velocity->linear_mps, b.ego_velocity->linear_mps);
  }
  EXPECT_NE(first.drive.scans[5].scan.range_m, third.drive.scans[5].scan.range_m);
}

TEST(SimulationTest, ScansAndSignalsComeAtTheirRates) {
  SimulationOptions options = Small(WorldKind::kTown, RadarKind::kArs408);
  options.scan_rate_hz = 40.0;
  options.signal_rate_hz = 100.0;
  const SimulatedPass pass = PassOf(options, 1);
  const auto& scans = pass.drive.scans;
  const double duration_s =
      std::chrono::duration<double>(scans.back().scan.stamp - scans.front().scan.stamp).count();
  EXPECT_NEAR(static_cast<double>(scans.size() - 1) / duration_s, 40.0, 0.5);
  EXPECT_EQ(pass.signals[8].stamp - pass.signals[7].stamp, std::chrono::milliseconds(10));
}

TEST(SimulationTest, AnotherDayHasOtherDrivesAndParkedVehiclesInTheSameTown) {
  SimulationOptions options = Small(WorldKind::kTown, RadarKind::kArs408);
  options.parked_change_share = 0.5;
  const SimulatedPass first = PassOf(options, 1);
  options.day = 7;
  const SimulatedPass later = PassOf(options, 1);
  EXPECT_GT(later.drive.scans.front().scan.stamp,
            first.drive.scans.front().scan.stamp + std::chrono::days(6));
  EXPECT_NE(first.drive.scans[5].scan.range_m, later.drive.scans[5].scan.range_m);
  const auto places = [](const SimulatedPass& pass) {
    std::set<double> xs_m;
    for (const auto& parked : pass.parked) xs_m.insert(parked.T_map_body.translation_m.x());
    return xs_m;
  };
  std::vector<double> both;
  std::ranges::set_intersection(places(first), places(later), std::back_inserter(both));
  EXPECT_FALSE(both.empty());
  EXPECT_LT(both.size(), places(first).size());
}

TEST(SimulationTest, LivePassesSeeTheWorldAged) {
  SimulationOptions options = Small(WorldKind::kTown, RadarKind::kArs408);
  const std::vector<PassOptions> passes = Passes(options);
  const auto map = SimulatePass(options, passes[0]);
  const auto live = SimulatePass(options, passes[1]);
  options.ageing.post_count = 30;
  const auto aged_map = SimulatePass(options, passes[0]);
  const auto aged_live = SimulatePass(options, passes[1]);
  ASSERT_TRUE(map.ok() && live.ok() && aged_map.ok() && aged_live.ok());
  const auto same = [](const Drive& a, const Drive& b) {
    return std::ranges::equal(a.scans, b.scans, [](const DriveScan& x, const DriveScan& y) {
      return x.scan.range_m == y.scan.range_m;
    });
  };
  EXPECT_TRUE(same(*map, *aged_map));
  EXPECT_FALSE(same(*live, *aged_live));
}

TEST(SimulationTest, VehiclesTakeTurnsWithRigsOfTheirOwn) {
  SimulationOptions options = Small(WorldKind::kTown, RadarKind::kArs408);
  const SimulatedPass alone = PassOf(options, 1);
  options.vehicle_count = 2;
  const SimulatedPass first = PassOf(options, 0);
  const SimulatedPass second = PassOf(options, 1);
  EXPECT_EQ(first.vehicle, 0);
  EXPECT_EQ(second.vehicle, 1);
  const auto mount = [](const SimulatedPass& pass) {
    return pass.drive.rig.radars[0].T_vehicle_radar.translation_m;
  };
  EXPECT_EQ(mount(first), mount(alone));
  EXPECT_GT((mount(second) - mount(first)).norm(), 0.01);
  EXPECT_LT((mount(second) - mount(first)).norm(), 0.5);
}

/// What a pass sees from the middle of its world's tunnel, where the ends are farther than a radar
/// reaches: along the tunnel and to its left.
struct TunnelView {
  std::size_t scan_count = 0;
  std::vector<Eigen::Vector2d> reflections;
  std::size_t static_count = 0;
};

TunnelView LookInTunnel(const SimulationOptions& options, std::size_t pass) {
  const simulation::World world = MakeWorld(options);
  const simulation::PathPoint entry = world.route.At(world.tunnel->begin_m);
  const Pose2 T_tunnel_map = Pose2{entry.position_m, entry.heading_rad}.Inverse();
  TunnelView view;
  for (const ScanTruth& truth : PassOf(options, pass).truth) {
    const double along_m = (T_tunnel_map * truth.motion.T_map_vehicle.translation_m).x();
    if (along_m < 20.0 || along_m > options.tunnel_m - 110.0) continue;
    ++view.scan_count;
    for (const Echo& echo : truth.echoes) {
      if (echo.source == EchoSource::kStatic) ++view.static_count;
      if (echo.source != EchoSource::kReflection) continue;
      view.reflections.emplace_back(T_tunnel_map * Eigen::Vector2d(echo.p_map.head<2>()));
    }
  }
  return view;
}

TEST(SimulationTest, ATunnelShowsItsWallsAndNothingThatPersists) {
  for (const WorldKind world : {WorldKind::kTown, WorldKind::kHighway}) {
    SimulationOptions options = Small(world, RadarKind::kCarla);  // sees 100 m far
    options.length_m = 500.0;
    options.tunnel_m = 300.0;
    const double half_width_m = MakeWorld(options).tunnel->half_width_m;
    const TunnelView map = LookInTunnel(options, 0);
    const TunnelView live = LookInTunnel(options, 1);
    ASSERT_GT(map.scan_count, 50U);
    EXPECT_EQ(map.static_count, 0U);
    EXPECT_EQ(live.static_count, 0U);
    EXPECT_GT(map.reflections.size(), 15 * map.scan_count);
    for (const Eigen::Vector2d& reflection : map.reflections) {
      ASSERT_NEAR(std::abs(reflection.y()), half_width_m, 0.2);
    }
    const auto sorted_along = [](const TunnelView& view) {
      std::vector<double> along_m;
      for (const Eigen::Vector2d& reflection : view.reflections) along_m.push_back(reflection.x());
      std::ranges::sort(along_m);
      return along_m;
    };
    std::vector<double> common;
    std::ranges::set_intersection(sorted_along(map), sorted_along(live),
                                  std::back_inserter(common));
    EXPECT_TRUE(common.empty());
  }
}

TEST(SimulationTest, ScansAreValidOrderedAndFull) {
  for (const RadarKind radar : {RadarKind::kArs408, RadarKind::kCarla}) {
    for (const WorldKind world : {WorldKind::kTown, WorldKind::kHighway}) {
      SimulationOptions options = Small(world, radar);
      options.rig_size = 5;
      const SimulatedPass pass = PassOf(options, 1);
      std::map<std::string, std::vector<double>> counts;
      for (std::size_t i = 0; i < pass.drive.scans.size(); ++i) {
        const Scan& scan = pass.drive.scans[i].scan;
        EXPECT_TRUE(Validate(scan).ok()) << Validate(scan);
        EXPECT_EQ(scan.stamp.time_since_epoch().count() % 1000, 0);
        EXPECT_EQ(scan.size(), pass.truth[i].echoes.size());
        EXPECT_LE(scan.size(), radar == RadarKind::kArs408 ? 125U : 150U);
        EXPECT_GE(scan.stamp, pass.drive.scans[i > 0 ? i - 1 : 0].scan.stamp);
        counts[scan.radar_id].push_back(static_cast<double>(scan.size()));
      }
      EXPECT_EQ(counts.size(), 5U);
      double mean = 0.0;
      for (const double count : counts["RADAR_FRONT"]) mean += count;
      mean /= static_cast<double>(counts["RADAR_FRONT"].size());
      EXPECT_GT(mean, radar == RadarKind::kArs408 ? 40.0 : 80.0);
    }
  }
}

// Static targets keep to the Doppler equation with the pass's own poses, by differences of poses
// rather than by the simulator's velocities.
TEST(SimulationTest, StaticTargetsMoveByTheVehiclesPoses) {
  SimulationOptions options = Small(WorldKind::kTown, RadarKind::kCarla);
  options.ghost_share = 0.0;
  const SimulatedPass pass = PassOf(options, 0);
  const RadarModel& radar = pass.drive.rig.radars[0];
  const auto range_from = [&](std::size_t scan, const Eigen::Vector3d& p_map) {
    const Pose3 T_map_radar = pass.drive.scans[scan].T_map_vehicle * radar.T_vehicle_radar;
    return (p_map - T_map_radar.translation_m).norm();
  };
  int compared = 0;
  for (std::size_t i = 1; i + 1 < pass.drive.scans.size(); ++i) {
    const double dt = std::chrono::duration<double>(pass.drive.scans[i + 1].scan.stamp -
                                                    pass.drive.scans[i - 1].scan.stamp)
                          .count();
    for (const Echo& echo : pass.truth[i].echoes) {
      if (echo.source != EchoSource::kStatic || echo.observation.range_m < 25.0) continue;
      const double rate = (range_from(i + 1, echo.p_map) - range_from(i - 1, echo.p_map)) / dt;
      EXPECT_NEAR(echo.observation.range_rate_mps, rate, 0.1);
      ++compared;
    }
  }
  EXPECT_GT(compared, 2000);
}

TEST(SimulationTest, MeasurementsScatterAroundTheTruthAsTheRigSays) {
  const SimulationOptions options = Small(WorldKind::kTown, RadarKind::kCarla);
  const SimulatedPass pass = PassOf(options, 0);
  const RadarModel& radar = pass.drive.rig.radars[0];
  double count = 0.0, range = 0.0, azimuth = 0.0, rate = 0.0, bias = 0.0;
  for (std::size_t i = 0; i < pass.drive.scans.size(); ++i) {
    const Scan& scan = pass.drive.scans[i].scan;
    for (std::size_t k = 0; k < scan.size(); ++k) {
      const simulation::Observation& truth = pass.truth[i].echoes[k].observation;
      const double range_error = scan.range_m[k] - truth.range_m - 0.04 * truth.range_rate_mps;
      range += range_error * range_error;
      bias += range_error;
      azimuth += std::pow(WrapAngle(scan.azimuth_rad[k] - truth.azimuth_rad), 2);
      rate += std::pow(scan.range_rate_mps[k] - truth.range_rate_mps, 2);
      count += 1.0;
    }
  }
  EXPECT_NEAR(std::sqrt(range / count), radar.range_sigma_m, 0.03 * radar.range_sigma_m);
  EXPECT_NEAR(std::sqrt(azimuth / count), radar.azimuth_sigma_rad, 0.03 * radar.azimuth_sigma_rad);
  EXPECT_NEAR(std::sqrt(rate / count), radar.range_rate_sigma_mps,
              0.03 * radar.range_rate_sigma_mps);
  EXPECT_NEAR(bias / count, 0.0, 4.0 * radar.range_sigma_m / std::sqrt(count));
}

TEST(SimulationTest, WithoutNoiseTheTruthIsMeasuredByTheSameRig) {
  SimulationOptions options = Small(WorldKind::kTown, RadarKind::kArs408);
  const Rig noisy = PassOf(options, 0).drive.rig;
  options.noise_scale = 0.0;
  const SimulatedPass pass = PassOf(options, 0);
  EXPECT_EQ(pass.drive.rig.radars[0].range_sigma_m, noisy.radars[0].range_sigma_m);
  const Scan& scan = pass.drive.scans.front().scan;
  ASSERT_GT(scan.size(), 10U);
  for (std::size_t k = 0; k < scan.size(); ++k) {
    const simulation::Observation& truth = pass.truth.front().echoes[k].observation;
    EXPECT_NEAR(scan.range_m[k], truth.range_m + 0.04 * truth.range_rate_mps, 1e-4);
    EXPECT_NEAR(scan.azimuth_rad[k], truth.azimuth_rad, 1e-6);
  }
}

TEST(SimulationTest, ClutterAndGhostsHaveTheirShares) {
  SimulationOptions options = Small(WorldKind::kTown, RadarKind::kArs408);
  options.length_m = 400.0;
  const SimulatedPass pass = PassOf(options, 1);
  std::map<EchoSource, double> share;
  double count = 0.0;
  for (const ScanTruth& truth : pass.truth) {
    for (const Echo& echo : truth.echoes) share[echo.source] += 1.0;
    count += static_cast<double>(truth.echoes.size());
  }
  for (auto& [source, value] : share) value /= count;
  EXPECT_NEAR(share[EchoSource::kClutter], 0.04, 0.01);
  const double ghosts = share[EchoSource::kMirror] + share[EchoSource::kDoubleBounce];
  EXPECT_GT(ghosts, 0.015);
  EXPECT_LT(ghosts, 0.05);
  EXPECT_GT(share[EchoSource::kMoving], 0.02);
  EXPECT_GT(share[EchoSource::kStatic], 0.6);
}

TEST(SimulationTest, WheelsAndGyroscopeErrAsMuchAsTheyShould) {
  SimulationOptions options = Small(WorldKind::kHighway, RadarKind::kCarla);
  options.length_m = 1000.0;
  const SimulatedPass pass = PassOf(options, 1);
  double scale = 0.0, bias = 0.0, wheel = 0.0, gyro = 0.0;
  const auto count = static_cast<double>(pass.drive.scans.size());
  const auto each = [&](const auto& visit) {
    for (std::size_t i = 0; i < pass.drive.scans.size(); ++i) {
      visit(pass.truth[i].motion, *pass.drive.scans[i].scan.ego_velocity);
    }
  };
  each([&](const simulation::MotionState& truth, const EgoVelocity& measured) {
    EXPECT_FALSE(measured.covariance.has_value());
    EXPECT_EQ(measured.linear_mps.y(), 0.0);
    scale += measured.linear_mps.x() / truth.speed_mps / count;
    bias += (measured.angular_radps.z() - truth.yaw_rate_radps) / count;
  });
  EXPECT_NE(scale, 1.0);
  EXPECT_NEAR(scale, 1.0, 0.02);
  EXPECT_NEAR(bias, 0.0, 0.002);
  each([&](const simulation::MotionState& truth, const EgoVelocity& measured) {
    wheel += std::pow(measured.linear_mps.x() - scale * truth.speed_mps, 2) / count;
    gyro += std::pow(measured.angular_radps.z() - truth.yaw_rate_radps - bias, 2) / count;
  });
  // Interpolating between two messages leaves half to all of the variance: 2/3 on average.
  EXPECT_NEAR(std::sqrt(wheel), 0.02 * std::sqrt(2.0 / 3.0), 0.002);
  EXPECT_NEAR(std::sqrt(gyro), 0.001 * std::sqrt(2.0 / 3.0), 0.0001);
}

TEST(SimulationTest, PassesDriveAtTheirSpeeds) {
  SimulationOptions options = Small(WorldKind::kHighway, RadarKind::kCarla);
  options.length_m = 500.0;
  options.live_speeds_mps = {8.0, 25.0};
  const std::vector<PassOptions> passes = Passes(options);
  ASSERT_EQ(passes.size(), 3U);
  EXPECT_EQ(passes[0].name, "map");
  EXPECT_EQ(passes[2].name, "live-1");
  for (const PassOptions& pass : passes) {
    const auto drive = SimulatePass(options, pass);
    ASSERT_TRUE(drive.ok());
    EXPECT_EQ(drive->name, pass.name);
    EXPECT_EQ(drive->place, "sim-highway");
    const double duration_s = std::chrono::duration<double>(drive->scans.back().scan.stamp -
                                                            drive->scans.front().scan.stamp)
                                  .count();
    EXPECT_NEAR(500.0 / duration_s, pass.mean_speed_mps, 0.03 * pass.mean_speed_mps);
  }
}

TEST(SimulationOptionsTest, NameWhatIsWrong) {
  const auto message = [](const auto& change) {
    SimulationOptions options;
    change(options);
    const absl::Status status = Validate(options);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_FALSE(SimulatePass(options, PassOptions{}).ok());
    return std::string(status.message());
  };
  EXPECT_TRUE(Validate(SimulationOptions{}).ok());
  EXPECT_EQ(message([](SimulationOptions& o) { o.rig_size = 3; }),
            "rig_size is 3; it must be 1 or 5");
  EXPECT_EQ(message([](SimulationOptions& o) { o.length_m = 1.0; }),
            "length_m is 1; it must lie in [50, 20000]");
  EXPECT_THAT(message([](SimulationOptions& o) { o.beta_s = std::nan(""); }),
              HasSubstr("beta_s is nan"));
  EXPECT_THAT(message([](SimulationOptions& o) {
                o.live_speeds_mps = {10.0, -1.0};
              }),
              HasSubstr("live_speeds_mps[1] is -1"));
  EXPECT_THAT(message([](SimulationOptions& o) { o.noise = NoiseKind::kGamma; }),
              HasSubstr("carla"));
  EXPECT_EQ(message([](SimulationOptions& o) { o.noise_scale = -1.0; }),
            "noise_scale is -1; it must lie in [0, 10]");
  EXPECT_FALSE(SimulatePass({}, {"", 0, 10.0}).ok());
  EXPECT_FALSE(SimulatePass({}, {"x", -1, 10.0}).ok());
  EXPECT_THAT(message([](SimulationOptions& o) { o.tunnel_m = 901.0; }),
              HasSubstr("tunnel_m is 901; it must lie in [20, 900]"));
  EXPECT_FALSE(SimulatePass({}, {"x", 0, 0.0}).ok());
}

}  // namespace
}  // namespace dcloc
