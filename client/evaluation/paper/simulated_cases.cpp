#include "client/evaluation/paper/simulated_cases.h"

#include <string>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "client/simulation/option_names.h"
#include "client/simulation/simulation.h"

namespace dcloc::paper {
namespace {

constexpr double kMpsPerKmh = 1.0 / 3.6;

/// A live pass: how it is called and driven.
struct LivePass {
  const char* name;
  int index;
  double speed_kmh;
  bool stops;
};

// Pass 0 is the map's.
constexpr LivePass kSlow = {"40kmh", 1, 40.0, false};
constexpr LivePass kTownMixed = {"stops", 2, 60.0, true};
constexpr LivePass kHighwayMixed = {"100kmh", 2, 100.0, false};

Case MakeCase(const SimulationOptions& options, const LivePass& pass, std::string set,
              Purpose purpose) {
  Case item{.set = std::move(set), .purpose = purpose};
  item.name = absl::StrCat("sim-", NameOf(options.radar), "-", NameOf(options.world), "-",
                           NameOf(options.noise), "-seed", options.seed, "-", pass.name);
  item.load = [options, pass]() -> absl::StatusOr<DrivePair> {
    auto map = SimulatePass(options, {.name = "map", .mean_speed_mps = options.map_speed_mps});
    if (!map.ok()) return map.status();
    SimulationOptions live_options = options;
    live_options.stops = pass.stops;
    auto live = SimulatePass(
        live_options,
        {.name = pass.name, .index = pass.index, .mean_speed_mps = pass.speed_kmh * kMpsPerKmh});
    if (!live.ok()) return live.status();
    return DrivePair{*std::move(map), *std::move(live)};
  };
  return item;
}

std::string SetName(RadarKind radar, WorldKind world) {
  return absl::StrCat("simulated ", absl::AsciiStrToUpper(NameOf(radar)), ", ", NameOf(world));
}

}  // namespace

std::vector<Case> SimulatedCases(bool quick) {
  const double length_m = quick ? 120.0 : 500.0;
  const std::uint64_t seeds = quick ? 1 : 2;
  std::vector<Case> cases;
  for (const auto& [radar_name, radar] : kRadarNames) {
    for (const auto& [world_name, world] : kWorldNames) {
      if (quick && (radar == RadarKind::kCarla || world == WorldKind::kHighway)) continue;
      for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
        const SimulationOptions options{
            .world = world, .radar = radar, .seed = seed, .length_m = length_m};
        const Purpose purpose = seed == 1 ? Purpose::kAblations : Purpose::kMethods;
        const std::string set = SetName(radar, world);
        cases.push_back(MakeCase(options, kSlow, set, purpose));
        if (quick) continue;
        const LivePass& mixed = world == WorldKind::kTown ? kTownMixed : kHighwayMixed;
        cases.push_back(MakeCase(options, mixed, set, purpose));
      }
    }
  }
  for (const auto& [noise_name, noise] : kNoiseNames) {
    if (quick && noise != NoiseKind::kRayleigh) continue;
    // A world of its own, so that no run is counted in two tables.
    const SimulationOptions options{
        .radar = RadarKind::kCarla, .noise = noise, .seed = 11, .length_m = length_m};
    const std::string set = absl::StrCat("noise ", noise_name);
    cases.push_back(MakeCase(options, kSlow, set, Purpose::kNoise));
    if (!quick) cases.push_back(MakeCase(options, kTownMixed, set, Purpose::kNoise));
  }
  return cases;
}

}  // namespace dcloc::paper
