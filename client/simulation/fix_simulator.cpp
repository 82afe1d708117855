#include "client/simulation/fix_simulator.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "client/datasets/files/check_range.h"
#include "client/simulation/world/random.h"
#include "core/geometry/degrees.h"
#include "core/geometry/geodetic_heading.h"

namespace dcloc {
namespace {

using simulation::MakeRandom;
using simulation::Normal;
using simulation::Random;
using simulation::Stream;
using simulation::Uniform;

/// A while during which a receiver is off, or says nothing.
struct Disturbance {
  double begin_s = 0.0;
  double end_s = 0.0;
  Eigen::Vector3d bias_m = Eigen::Vector3d::Zero();
};

std::vector<Disturbance> DrawDisturbances(double per_min, double each_s, double size_m,
                                          double duration_s, Random random) {
  std::vector<Disturbance> drawn;
  if (per_min <= 0.0) return drawn;
  std::exponential_distribution<double> gap_s(per_min / 60.0);
  for (double t_s = gap_s(random); t_s < duration_s; t_s += each_s + gap_s(random)) {
    const double length_m = size_m * Uniform(random, 0.5, 1.5);
    const double direction_rad = Uniform(random, 0.0, 2.0 * std::numbers::pi);
    drawn.push_back(
        {t_s,
         t_s + each_s,
         {length_m * std::cos(direction_rad), length_m * std::sin(direction_rad), 0.0}});
  }
  return drawn;
}

const Disturbance* FindAt(const std::vector<Disturbance>& disturbances, double t_s) {
  const auto found = std::ranges::find_if(
      disturbances, [t_s](const Disturbance& d) { return d.begin_s <= t_s && t_s < d.end_s; });
  return found == disturbances.end() ? nullptr : &*found;
}

/// `pose` is what the receiver believes.
StampedFix FixAt(Stamp stamp, const Pose3& T_map_vehicle, const FixOptions& options,
                 const std::optional<GeodeticAnchor>& anchor) {
  const bool has_heading = options.heading_sigma_deg > 0.0;
  if (!anchor) {
    const Eigen::Vector3d ahead = T_map_vehicle.rotation * Eigen::Vector3d::UnitX();
    MapFix fix{.p_map = T_map_vehicle.translation_m,
               .horizontal_sigma_m = options.sigma_m,
               .vertical_sigma_m = 2.0 * options.sigma_m,
               .yaw_deg = {},
               .yaw_sigma_deg = options.heading_sigma_deg};
    if (has_heading) fix.yaw_deg = std::atan2(ahead.y(), ahead.x()) * kDegPerRad;
    return {stamp, fix};
  }
  GnssFix fix{.position = GeodeticFromMap(*anchor, T_map_vehicle.translation_m),
              .horizontal_sigma_m = options.sigma_m,
              .vertical_sigma_m = 2.0 * options.sigma_m,
              .heading_deg = {},
              .heading_sigma_deg = options.heading_sigma_deg};
  if (has_heading) fix.heading_deg = HeadingFromMap(*anchor, T_map_vehicle);
  return {stamp, fix};
}

Pose3 WithNoise(Pose3 pose, const FixOptions& options, Random& random) {
  for (const int axis : {0, 1, 2}) {
    const double sigma_m = axis == 2 ? 2.0 * options.sigma_m : options.sigma_m;
    pose.translation_m[axis] += Normal(random, 0.0, sigma_m);
  }
  const double yaw_rad = Normal(random, 0.0, options.heading_sigma_deg * kRadPerDeg);
  pose.rotation = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()) * pose.rotation;
  return pose;
}

}  // namespace

absl::Status Validate(const FixOptions& options) {
  absl::Status status = CheckRange("fixes rate_hz", options.rate_hz, 0.0, 50.0);
  status.Update(CheckRange("fixes sigma_m", options.sigma_m, 0.01, 1000.0));
  status.Update(CheckRange("fixes heading_sigma_deg", options.heading_sigma_deg, 0.0, 90.0));
  status.Update(CheckRange("fixes jumps_per_min", options.jumps_per_min, 0.0, 60.0));
  status.Update(CheckRange("fixes jump_m", options.jump_m, 0.0, 10'000.0));
  status.Update(CheckRange("fixes jump_s", options.jump_s, 0.1, 3600.0));
  status.Update(CheckRange("fixes outages_per_min", options.outages_per_min, 0.0, 60.0));
  status.Update(CheckRange("fixes outage_s", options.outage_s, 0.1, 3600.0));
  return status;
}

std::vector<StampedFix> SimulateFixes(const SimulatedPass& pass, int pass_index,
                                      const FixOptions& options, std::uint64_t seed,
                                      const std::optional<GeodeticAnchor>& anchor) {
  std::vector<StampedFix> fixes;
  if (options.rate_hz <= 0.0 || pass.drive.scans.empty()) return fixes;
  const auto random_for = [&](std::uint64_t purpose) {
    return MakeRandom(seed, Stream::kFixes, {static_cast<std::uint64_t>(pass_index), purpose});
  };
  const Stamp begin = pass.drive.scans.front().scan.stamp;
  const Stamp end = pass.drive.scans.back().scan.stamp;
  const double duration_s = std::chrono::duration<double>(end - begin).count();
  const auto jumps = DrawDisturbances(options.jumps_per_min, options.jump_s, options.jump_m,
                                      duration_s, random_for(1));
  const auto outages =
      DrawDisturbances(options.outages_per_min, options.outage_s, 0.0, duration_s, random_for(2));
  Random random = random_for(0);
  double next_s = 0.0;
  for (const VehicleSignal& signal : pass.signals) {
    const double t_s = std::chrono::duration<double>(signal.stamp - begin).count();
    if (t_s < next_s || signal.stamp > end) continue;
    next_s += 1.0 / options.rate_hz;
    Pose3 measured = WithNoise(signal.T_map_vehicle, options, random);
    if (const Disturbance* jump = FindAt(jumps, t_s)) measured.translation_m += jump->bias_m;
    if (FindAt(outages, t_s) != nullptr) continue;
    fixes.push_back(FixAt(signal.stamp, measured, options, anchor));
  }
  return fixes;
}

}  // namespace dcloc
