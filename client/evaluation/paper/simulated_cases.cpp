#include "client/evaluation/paper/simulated_cases.h"

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "client/simulation/option_names.h"
#include "client/simulation/simulation.h"

namespace dcloc::paper {
namespace {

// Drives on which nothing was tuned. Noises have a world of their own, so that no run is counted
// in two tables.
constexpr std::uint64_t kFirstSeed = 41;
constexpr std::uint64_t kNoiseSeed = 51;

/// A live pass: how it is called and driven.
struct LivePass {
  absl::string_view name;
  double speed_kmh;
  int index;
  bool stops;
};

// Pass 0 is the map's.
constexpr LivePass kSlow = {"40kmh", 40.0, 1, false};
constexpr LivePass kStops = {"stops", 60.0, 2, true};
constexpr LivePass kFast = {"100kmh", 100.0, 3, false};
constexpr LivePass kSlowest = {"20kmh", 20.0, 4, false};

// Towns are driven through at all speeds that a goal speaks of.
std::vector<LivePass> LivePasses(WorldKind world, RadarKind radar) {
  if (world == WorldKind::kHighway) return {kSlow, kFast};
  if (radar == RadarKind::kArs408) return {kSlow, kStops, kFast, kSlowest};
  return {kSlow, kStops};
}

constexpr LivePass kNoisePasses[] = {kSlow, {"60kmh", 60.0, 2, false}, kFast, kSlowest};

absl::StatusOr<Drive> MapPass(const SimulationOptions& options) {
  return SimulatePass(options, {.name = "map", .mean_speed_mps = options.map_speed_mps});
}

Case MakeCase(const SimulationOptions& options, const LivePass& pass, std::string set,
              Purpose purpose) {
  Case item{.set = std::move(set), .purpose = purpose};
  item.name = absl::StrCat("sim-", NameOf(options.radar), "-", NameOf(options.world), "-",
                           NameOf(options.noise), "-seed", options.seed, "-", pass.name);
  item.load = [options, pass]() -> absl::StatusOr<DrivePair> {
    auto map = MapPass(options);
    if (!map.ok()) return map.status();
    SimulationOptions live_options = options;
    live_options.stops = pass.stops;
    auto live = SimulatePass(live_options, {.name = std::string(pass.name),
                                            .index = pass.index,
                                            .mean_speed_mps = pass.speed_kmh * kMpsPerKmh});
    if (!live.ok()) return live.status();
    return DrivePair{*std::move(map), *std::move(live)};
  };
  item.load_calibration = [options]() -> absl::StatusOr<std::vector<Drive>> {
    auto map = MapPass(options);
    if (!map.ok()) return map.status();
    return std::vector<Drive>{*std::move(map)};
  };
  return item;
}

std::string SetName(RadarKind radar, WorldKind world) {
  return absl::StrCat("simulated ", absl::AsciiStrToUpper(NameOf(radar)), ", ", NameOf(world));
}

}  // namespace

std::vector<Case> SimulatedCases(bool quick) {
  const double length_m = quick ? 120.0 : 400.0;
  std::vector<Case> cases;
  const auto add = [&](const SimulationOptions& options, std::span<const LivePass> passes,
                       const std::string& set, Purpose purpose) {
    for (const LivePass& pass : quick ? passes.first(1) : passes) {
      // The ablations are of one speed.
      const bool is_slow = pass.name == kSlow.name || purpose == Purpose::kNoise;
      cases.push_back(MakeCase(options, pass, set, is_slow ? purpose : Purpose::kMethods));
    }
  };
  for (const auto& [radar_name, radar] : kRadarNames) {
    for (const auto& [world_name, world] : kWorldNames) {
      if (quick && (radar == RadarKind::kCarla || world == WorldKind::kHighway)) continue;
      const std::uint64_t seeds = !quick && world == WorldKind::kTown ? 2 : 1;
      for (std::uint64_t i = 0; i < seeds; ++i) {
        add({.world = world, .radar = radar, .seed = kFirstSeed + i, .length_m = length_m},
            LivePasses(world, radar), SetName(radar, world),
            i == 0 ? Purpose::kAblations : Purpose::kMethods);
      }
    }
  }
  for (const auto& [noise_name, noise] : kNoiseNames) {
    if (quick && noise != NoiseKind::kRayleigh) continue;
    add({.radar = RadarKind::kCarla, .noise = noise, .seed = kNoiseSeed, .length_m = length_m},
        kNoisePasses, absl::StrCat("noise ", noise_name), Purpose::kNoise);
  }
  return cases;
}

}  // namespace dcloc::paper
