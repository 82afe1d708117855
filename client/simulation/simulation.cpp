#include "client/simulation/simulation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/simulation/motion/traffic.h"
#include "client/simulation/radar/scan_simulator.h"
#include "client/simulation/radar/scene.h"
#include "client/simulation/world/parking.h"
#include "client/simulation/world/steps.h"

namespace dcloc {
namespace {

using simulation::EgoMotion;
using simulation::MakeRandom;
using simulation::MotionState;
using simulation::Normal;
using simulation::Random;
using simulation::Stream;
using simulation::World;

constexpr std::chrono::sys_days kFirstDay{std::chrono::year{2024} / 5 / 1};
constexpr std::chrono::hours kDeparture{10};
constexpr double kClockJitter = 0.0015;  // of a radar's period [s]
constexpr double kGravity = 9.81;        // [m/s^2]
constexpr double kWheelScaleSigma = 0.005;
constexpr double kWheelNoise = 0.02;       // [m/s]
constexpr double kGyroBiasSigma = 0.0005;  // [rad/s]
constexpr double kGyroNoise = 0.001;       // [rad/s]

// Each pass on its own day.
Stamp Departure(int day, int pass_index) {
  return kFirstDay + std::chrono::days(day + pass_index) + kDeparture;
}

// Whole microseconds: what the nuScenes layout can say.
std::chrono::microseconds Microseconds(double t_s) {
  return std::chrono::microseconds(std::llround(t_s * 1e6));
}

double Seconds(std::chrono::microseconds time) { return 1e-6 * static_cast<double>(time.count()); }

simulation::RadarProfile ProfileOf(const SimulationOptions& options) {
  return options.radar == RadarKind::kArs408 ? simulation::Ars408Profile()
                                             : simulation::CarlaProfile(options.noise);
}

simulation::RadarProfile Noisier(simulation::RadarProfile profile, double scale) {
  for (simulation::Noise* noise :
       {&profile.range_m, &profile.azimuth_rad, &profile.elevation_rad, &profile.range_rate_mps}) {
    noise->scale *= scale;
  }
  return profile;
}

// The rig of a further vehicle: each radar some decimetres and degrees elsewhere.
Rig RigOfVehicle(Rig rig, std::uint64_t seed, int vehicle) {
  if (vehicle == 0) return rig;
  for (std::size_t i = 0; i < rig.radars.size(); ++i) {
    Random random = MakeRandom(seed, Stream::kVehicle, {static_cast<std::uint64_t>(vehicle), i});
    Pose3& T_vehicle_radar = rig.radars[i].T_vehicle_radar;
    for (const auto& [axis, reach_m] : {std::pair(0, 0.4), std::pair(1, 0.1), std::pair(2, 0.15)}) {
      T_vehicle_radar.translation_m(axis) += simulation::Uniform(random, -reach_m, reach_m);
    }
    T_vehicle_radar.rotation =
        T_vehicle_radar.rotation *
        Eigen::AngleAxisd(simulation::Uniform(random, -0.07, 0.07), Eigen::Vector3d::UnitZ());
  }
  return rig;
}

// One pass while it is being driven.
class PassSimulator {
 public:
  PassSimulator(const World& world, const SimulationOptions& options, const PassOptions& pass)
      : world_(world),
        options_(options),
        pass_(pass),
        lane_offset_m_(world.ego_lane_offsets_m[static_cast<std::size_t>(pass.index) %
                                                world.ego_lane_offsets_m.size()]),
        route_(pass.is_reversed ? world.route.Reversed() : world.route),
        motion_(MakeMotion()),
        parked_(simulation::ParkVehicles(world, options.seed, DrawOf(options.day, pass.index),
                                         options.parked_change_share)),
        scene_(world, parked_),
        traffic_(MakeTraffic()),
        simulator_{Noisier(ProfileOf(options), options.noise_scale), options.clutter_share,
                   options.ghost_share, options.range_rate_step_mps, options.is_flat},
        vehicle_(pass.index % options.vehicle_count),
        rig_(RigOfVehicle(
            simulation::MakeRig(ProfileOf(options), options.rig_size, options.beta_s,
                                options.has_elevation, options.unambiguous_range_rate_mps),
            options.seed, vehicle_)) {}

  SimulatedPass Run(const std::function<void(double)>& progress) const {
    SimulatedPass result;
    result.drive.name = pass_.name;
    result.drive.place = "sim-" + world_.name;
    result.drive.rig = rig_;
    result.signals = RecordSignals();
    result.vehicle = vehicle_;
    result.parked = parked_;
    for (const auto& [time, radar] : Schedule()) {
      Record(time, radar, result);
      if (progress) progress(Seconds(time) / motion_.duration_s());
    }
    return result;
  }

 private:
  Random RandomFor(Stream stream, std::uint64_t index = 0) const {
    return MakeRandom(options_.seed, stream,
                      {static_cast<std::uint64_t>(DrawOf(options_.day, pass_.index)), index});
  }

  EgoMotion MakeMotion() const {
    Random random = RandomFor(Stream::kSpeed);
    simulation::SpeedProfileOptions speed;
    speed.begin_m = world_.drive_begin_m + pass_.begin_m;
    speed.end_m = speed.begin_m + world_.length_m;
    speed.mean_speed_mps = pass_.mean_speed_mps;
    speed.max_lateral_acceleration_mps2 = world_.max_lateral_acceleration_mps2;
    for (const double stop_m : world_.stop_lines_m) {
      const bool inside = stop_m > speed.begin_m && stop_m < speed.end_m;
      if (options_.stops && inside && simulation::Chance(random, 0.5))
        speed.stops_m.push_back(stop_m);
    }
    Random lane = RandomFor(Stream::kLane);
    const double offset_m = lane_offset_m_ + simulation::Uniform(lane, -0.4, 0.4);
    return {route_, MakeSpeedProfile(route_, speed, random),
            simulation::LaneKeeping(offset_m, lane)};
  }

  simulation::Traffic MakeTraffic() const {
    Random random = RandomFor(Stream::kTraffic);
    const double lane_m = pass_.is_reversed ? -lane_offset_m_ : lane_offset_m_;
    return {world_, motion_, lane_m, pass_.mean_speed_mps, random};
  }

  std::vector<VehicleSignal> RecordSignals() const {
    Random random = RandomFor(Stream::kSignals);
    const double wheel_scale = Normal(random, 1.0, kWheelScaleSigma);
    const double gyro_bias = Normal(random, 0.0, kGyroBiasSigma);
    std::vector<VehicleSignal> signals;
    const double period_s = 1.0 / options_.signal_rate_hz;
    for (const double t :
         simulation::Steps(-period_s, motion_.duration_s() + 2.0 * period_s, period_s)) {
      const std::chrono::microseconds time = Microseconds(t);
      const MotionState state = motion_.At(Seconds(time));
      const double change = motion_.At(t + 0.01).speed_mps - motion_.At(t - 0.01).speed_mps;
      signals.push_back({Departure(options_.day, pass_.index) + time,
                         Embed(state.T_map_vehicle),
                         wheel_scale * state.speed_mps + Normal(random, 0.0, kWheelNoise),
                         state.yaw_rate_radps + gyro_bias + Normal(random, 0.0, kGyroNoise),
                         {change / 0.02, state.speed_mps * state.yaw_rate_radps, kGravity}});
    }
    return signals;
  }

  double PeriodOfScans_s() const {
    return options_.scan_rate_hz == 0.0 ? simulator_.profile.period_s : 1.0 / options_.scan_rate_hz;
  }

  // When each radar scans: free-running clocks, ascending over all radars.
  std::vector<std::pair<std::chrono::microseconds, std::size_t>> Schedule() const {
    std::vector<std::pair<std::chrono::microseconds, std::size_t>> schedule;
    for (std::size_t radar = 0; radar < rig_.radars.size(); ++radar) {
      Random random = RandomFor(Stream::kClock, radar);
      const double period = PeriodOfScans_s() * simulation::Uniform(random, 0.99, 1.01);
      const double first = simulation::Uniform(random, 0.0, period);
      for (const double t : simulation::Steps(first, motion_.duration_s(), period)) {
        const double jitter = std::clamp(Normal(random, 0.0, kClockJitter), -0.005, 0.005);
        schedule.emplace_back(Microseconds(std::max(0.0, t + jitter)), radar);
      }
    }
    std::sort(schedule.begin(), schedule.end());
    return schedule;
  }

  // As a reader of the vehicle bus would: linear between the two nearest messages.
  EgoVelocity MeasuredVelocity(const std::vector<VehicleSignal>& signals, Stamp stamp) const {
    const auto after = std::upper_bound(
        signals.begin() + 1, signals.end() - 1, stamp,
        [](Stamp value, const VehicleSignal& signal) { return value < signal.stamp; });
    const VehicleSignal& next = *after;
    const VehicleSignal& previous = *std::prev(after);
    const double u = std::chrono::duration<double>(stamp - previous.stamp) /
                     std::chrono::duration<double>(next.stamp - previous.stamp);
    EgoVelocity velocity;
    velocity.linear_mps.x() = std::lerp(previous.speed_mps, next.speed_mps, u);
    velocity.angular_radps.z() = std::lerp(previous.yaw_rate_radps, next.yaw_rate_radps, u);
    return velocity;
  }

  void Record(std::chrono::microseconds time, std::size_t radar, SimulatedPass& result) const {
    const double t = Seconds(time);
    const MotionState state = motion_.At(t);
    const double radius_m =
        std::max(simulator_.profile.max_range_m, simulator_.profile.far_max_range_m) + 20.0;
    Random random = RandomFor(Stream::kScan, result.drive.scans.size());
    simulation::SimulatedScan simulated = SimulateScan(scene_, traffic_.At(t, radius_m), state,
                                                       rig_.radars[radar], simulator_, random);
    simulated.scan.stamp = Departure(options_.day, pass_.index) + time;
    simulated.scan.radar_id = rig_.radars[radar].id;
    simulated.scan.ego_velocity = MeasuredVelocity(result.signals, simulated.scan.stamp);
    result.drive.scans.push_back({std::move(simulated.scan), Embed(state.T_map_vehicle)});
    result.truth.push_back({state, std::move(simulated.echoes)});
  }

  const World& world_;
  const SimulationOptions& options_;
  const PassOptions& pass_;
  double lane_offset_m_;
  simulation::Path route_;
  EgoMotion motion_;
  std::vector<simulation::ParkedVehicle> parked_;
  simulation::Scene scene_;
  simulation::Traffic traffic_;
  simulation::ScanSimulatorOptions simulator_;
  int vehicle_;
  Rig rig_;
};

}  // namespace

simulation::World MakeWorld(const SimulationOptions& options) {
  if (options.loop_m > 0.0) {
    return simulation::MakeTownRing(options.seed, options.length_m, options.loop_m);
  }
  return simulation::MakeWorld(options.world, options.seed, options.length_m, options.tunnel_m);
}

simulation::AgedWorld AgeWorld(const simulation::World& world, const SimulationOptions& options) {
  return simulation::Age(world, options.ageing, options.seed);
}

absl::StatusOr<SimulatedPass> SimulatePassWithTruth(const simulation::World& world,
                                                    const SimulationOptions& options,
                                                    const PassOptions& pass,
                                                    const std::function<void(double)>& progress) {
  absl::Status status = Validate(options);
  status.Update(Validate(pass));
  if (!world.route.is_closed() && (pass.begin_m != 0.0 || pass.is_reversed)) {
    status.Update(absl::InvalidArgumentError(
        absl::StrCat("pass ", pass.name, " begins elsewhere or is reversed: only on a ring")));
  }
  if (!status.ok()) return status;
  return PassSimulator(world, options, pass).Run(progress);
}

absl::StatusOr<Drive> SimulatePass(const SimulationOptions& options, const PassOptions& pass) {
  if (absl::Status status = Validate(options); !status.ok()) return status;
  simulation::World world = MakeWorld(options);
  if (pass.index > 0) world = AgeWorld(world, options).world;
  absl::StatusOr<SimulatedPass> simulated = SimulatePassWithTruth(world, options, pass);
  if (!simulated.ok()) return simulated.status();
  return std::move(simulated->drive);
}

}  // namespace dcloc
