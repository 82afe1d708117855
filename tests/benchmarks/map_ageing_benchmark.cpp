// Maps of simulated towns that age: what an update of three passes keeps, loses and finds, and how
// well the new version localizes a pass that had no part in it.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "client/datasets/drive_map.h"
#include "core/update/map_update.h"
#include "tests/benchmarks/ageing_town.h"
#include "tests/benchmarks/ageing_truth.h"

namespace dcloc::benchmarks {
namespace {

/// What is asked for: `--seeds FIRST LAST`, or one short town with `--smoke`.
struct Arguments {
  std::uint64_t first_seed = 11;
  std::uint64_t last_seed = 15;
  double length_m = 600.0;
  int rig_size = 1;
};

double Percent(std::size_t part, std::size_t whole) {
  return whole == 0 ? NAN : 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

void Print(const std::string& name, const AgeingCounts& counts, double old_m, double new_m,
           double anew_m) {
  std::printf("%-6s %6zu %6zu %6.1f %6zu %6.2f %6zu %6.1f %6.1f %6.1f %7.4f %7.4f %7.4f\n",
              name.c_str(), counts.landmarks, counts.went, Percent(counts.went_gone, counts.went),
              counts.stood, Percent(counts.stood_lost, counts.stood), counts.came,
              Percent(counts.came_found, counts.came), Percent(counts.base_parked, counts.stood),
              Percent(counts.parked, counts.landmarks), old_m, new_m, anew_m);
  std::fflush(stdout);
}

void Run(const Arguments& arguments) {
  std::printf(
      "three passes, 10 %% replaced, parked vehicles change daily; shares in %%, median errors in "
      "m\n%-6s %6s %6s %6s %6s %6s %6s %6s %6s %6s %7s %7s %7s\n",
      "seed", "new", "went", "gone", "stood", "lost", "came", "found", "b.park", "parked", "old",
      "updated", "anew");
  for (std::uint64_t seed = arguments.first_seed; seed <= arguments.last_seed; ++seed) {
    const Town town = MakeAgedTown(seed, arguments.length_m, arguments.rig_size);
    const auto base = RadarMap::FromBytes(BuildMap(town.base.drive, {.name = "base"}).value());
    const std::vector<PlacedPass> placed = PlacePasses(*base, town);
    const MapUpdate update = UpdateMap(ToEditable(**base), placed).value();
    const auto updated = RadarMap::FromBytes(ToMapBytes(update.map).value()).value();
    Print(std::to_string(seed), CountAgeing(update, town.aged, town.base, town.passes, placed),
          MedianError_m(*base, town.held_out), MedianError_m(updated, town.held_out),
          MedianError_m(MadeAnew(town), town.held_out));
  }
}

}  // namespace
}  // namespace dcloc::benchmarks

int main(int argc, char** argv) {
  dcloc::benchmarks::Arguments arguments;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--smoke") {
      arguments.last_seed = arguments.first_seed;
      arguments.length_m = 250.0;
    } else if (argument == "--seeds" && i + 2 < argc) {
      arguments.first_seed = std::strtoull(argv[++i], nullptr, 10);
      arguments.last_seed = std::strtoull(argv[++i], nullptr, 10);
    } else if (argument == "--rig" && i + 1 < argc) {
      arguments.rig_size = std::atoi(argv[++i]);
    } else {
      std::fprintf(stderr, "usage: %s [--smoke] [--seeds FIRST LAST] [--rig 1|5]\n", argv[0]);
      return 2;
    }
  }
  dcloc::benchmarks::Run(arguments);
  return 0;
}
