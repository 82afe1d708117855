#include "client/evaluation/faults/worlds.h"

#include "absl/strings/str_cat.h"
#include "client/simulation/simulation.h"

namespace dcloc::faults {
namespace {

// No world is another seed's, nor another campaign's.
constexpr std::uint64_t kFirstSeed = 5'000'000'000;
constexpr std::uint64_t kWorldsOfSeed = 1000;
constexpr int kWorldsOfKind = 3;
constexpr double kDrive_s = 70.0, kQuickDrive_s = 40.0;
// At a town's speed a drive is between its walls from 20 s on, when most faults begin.
constexpr double kTunnel_m = 360.0;

struct Kind {
  const char* name;
  double speed_kmh;
  bool stops;
  SimulationOptions options;
};

std::vector<Kind> Kinds() {
  SimulationOptions highway, tunnel, carla, five;
  highway.world = WorldKind::kHighway;
  tunnel.tunnel_m = kTunnel_m;
  carla.radar = RadarKind::kCarla;
  five.rig_size = 5;
  return {{"town", 40.0, false, {}},          {"highway", 100.0, false, highway},
          {"tunnel", 40.0, false, tunnel},    {"carla", 40.0, false, carla},
          {"five-radars", 40.0, false, five}, {"stop-and-go", 40.0, true, {}}};
}

World MakeFaultWorld(const Kind& kind, int number, std::uint64_t seed, double drive_s) {
  SimulationOptions options = kind.options;
  options.seed = seed;
  options.length_m = kind.speed_kmh * kMpsPerKmh * drive_s;
  const robustness::Pass pass{kind.speed_kmh, kind.stops};
  World world{.kind = kind.name, .name = absl::StrCat(kind.name, "-", number), .seed = seed};
  world.radar_count = static_cast<std::size_t>(options.rig_size);
  world.load = [options, pass, name = world.name] {
    return robustness::SimulateCourse(options, pass, name);
  };
  return world;
}

}  // namespace

std::vector<World> SimulatedWorlds(std::uint64_t seed, bool quick) {
  std::uint64_t world_seed = kFirstSeed + kWorldsOfSeed * seed;
  const std::vector<Kind> kinds = Kinds();
  if (quick) return {MakeFaultWorld(kinds.front(), 1, world_seed, kQuickDrive_s)};
  std::vector<World> worlds;
  for (const Kind& kind : kinds) {
    for (int number = 1; number <= kWorldsOfKind; ++number) {
      worlds.push_back(MakeFaultWorld(kind, number, ++world_seed, kDrive_s));
    }
  }
  return worlds;
}

}  // namespace dcloc::faults
