#include "client/simulation/simulation_options.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/datasets/files/check_range.h"

namespace dcloc {
namespace {

constexpr double kMinMeanSpeed_mps = 2.0;
constexpr double kMaxMeanSpeed_mps = 60.0;
constexpr std::size_t kMaxLivePasses = 100;
constexpr double kMinTunnel_m = 20.0;
constexpr double kMinLoop_m = 800.0;  // streets inside of a smaller ring would meet
constexpr double kMaxLoop_m = 20'000.0;
constexpr double kMaxBegin_m = 1e6;  // a hundred drives on the longest ring
constexpr int kMaxDay = 10'000;
constexpr double kMaxPostCount = 1000.0;
constexpr double kMaxLeafCount = 100.0;
constexpr double kLoopShareBetweenDrives = 0.37;
constexpr double kLengthWithoutTunnel_m = 100.0;  // of a drive, before and after

absl::Status ValidateKinds(const SimulationOptions& options) {
  if (options.rig_size != 1 && options.rig_size != 5) {
    return absl::InvalidArgumentError(
        absl::StrFormat("rig_size is %d; it must be 1 or 5", options.rig_size));
  }
  if (options.noise != NoiseKind::kGaussian && options.radar != RadarKind::kCarla) {
    return absl::InvalidArgumentError(
        "noise other than gaussian is defined (Table IV) for the carla radar only");
  }
  if (options.live_speeds_mps.size() > kMaxLivePasses) {
    return absl::InvalidArgumentError(absl::StrFormat("live_speeds_mps has %d entries; at most %d",
                                                      options.live_speeds_mps.size(),
                                                      kMaxLivePasses));
  }
  return absl::OkStatus();
}

absl::Status ValidateLoop(const SimulationOptions& options) {
  if (options.loop_m == 0.0) {
    if (!options.both_ways) return absl::OkStatus();
    return absl::InvalidArgumentError("both_ways needs a ring: loop_m is 0");
  }
  if (options.world != WorldKind::kTown || options.tunnel_m != 0.0) {
    return absl::InvalidArgumentError("loop_m makes a ring of a town without a tunnel only");
  }
  return CheckRange("loop_m", options.loop_m, kMinLoop_m, kMaxLoop_m);
}

absl::Status ValidateAgeing(const SimulationOptions& options) {
  const simulation::AgeingOptions& ageing = options.ageing;
  absl::Status status = CheckRange("day", options.day, 0.0, kMaxDay);
  status.Update(CheckRange("vehicle_count", options.vehicle_count, 1.0, kMaxLivePasses));
  status.Update(CheckRange("ageing.replaced_share", ageing.replaced_share, 0.0, 1.0));
  status.Update(CheckRange("ageing.site_m", ageing.site_m, 0.0, options.length_m));
  status.Update(CheckRange("ageing.post_count", ageing.post_count, 0.0, kMaxPostCount));
  status.Update(CheckRange("ageing.gone_wall_m", ageing.gone_wall_m, 0.0, options.length_m));
  status.Update(CheckRange("ageing.leaf_count", ageing.leaf_count, 0.0, kMaxLeafCount));
  if (status.ok() && options.world != WorldKind::kTown && ChangesWorld(ageing)) {
    return absl::InvalidArgumentError("ageing: only a town ages");
  }
  return status;
}

}  // namespace

absl::Status Validate(const SimulationOptions& options) {
  absl::Status status = ValidateKinds(options);
  status.Update(CheckRange("length_m", options.length_m, 50.0, 20'000.0));
  if (options.tunnel_m != 0.0) {
    status.Update(CheckRange("tunnel_m", options.tunnel_m, kMinTunnel_m,
                             options.length_m - kLengthWithoutTunnel_m));
  }
  status.Update(ValidateLoop(options));
  status.Update(
      CheckRange("map_speed_mps", options.map_speed_mps, kMinMeanSpeed_mps, kMaxMeanSpeed_mps));
  for (std::size_t i = 0; i < options.live_speeds_mps.size(); ++i) {
    status.Update(CheckRange(absl::StrCat("live_speeds_mps[", i, "]"), options.live_speeds_mps[i],
                             kMinMeanSpeed_mps, kMaxMeanSpeed_mps));
  }
  if (options.scan_rate_hz != 0.0) {
    status.Update(CheckRange("scan_rate_hz", options.scan_rate_hz, 0.1, 200.0));
  }
  status.Update(CheckRange("signal_rate_hz", options.signal_rate_hz, 1.0, 1000.0));
  status.Update(CheckRange("noise_scale", options.noise_scale, 0.0, 10.0));
  status.Update(CheckRange("beta_s", options.beta_s, -0.5, 0.5));
  status.Update(
      CheckRange("unambiguous_range_rate_mps", options.unambiguous_range_rate_mps, 0.0, 200.0));
  status.Update(CheckRange("range_rate_step_mps", options.range_rate_step_mps, 0.0, 5.0));
  status.Update(CheckRange("parked_change_share", options.parked_change_share, 0.0, 1.0));
  status.Update(CheckRange("clutter_share", options.clutter_share, 0.0, 0.5));
  status.Update(CheckRange("ghost_share", options.ghost_share, 0.0, 0.5));
  status.Update(ValidateAgeing(options));
  return status;
}

absl::Status Validate(const PassOptions& pass) {
  if (pass.name.empty()) return absl::InvalidArgumentError("pass name is empty");
  absl::Status status = CheckRange("pass index", pass.index, 0.0, kMaxLivePasses);
  status.Update(CheckRange("pass begin_m", pass.begin_m, 0.0, kMaxBegin_m));
  status.Update(
      CheckRange("pass mean_speed_mps", pass.mean_speed_mps, kMinMeanSpeed_mps, kMaxMeanSpeed_mps));
  return status;
}

std::vector<PassOptions> Passes(const SimulationOptions& options) {
  std::vector<PassOptions> passes = {{"map", 0, options.map_speed_mps}};
  for (std::size_t i = 0; i < options.live_speeds_mps.size(); ++i) {
    passes.push_back(
        {absl::StrCat("live-", i), static_cast<int>(i) + 1, options.live_speeds_mps[i]});
  }
  for (PassOptions& pass : passes) {
    pass.begin_m = kLoopShareBetweenDrives * options.loop_m * pass.index;
    pass.is_reversed = options.both_ways && pass.index % 2 == 1;
  }
  return passes;
}

}  // namespace dcloc
