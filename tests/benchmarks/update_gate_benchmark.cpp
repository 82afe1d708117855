// Versions of maps of simulated towns that aged, better ones and worse ones, before the gate.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "client/datasets/drive_map.h"
#include "core/update/map_update.h"
#include "core/versions/judged_version.h"
#include "core/versions/update_gate.h"
#include "tests/benchmarks/ageing_town.h"

namespace dcloc::benchmarks {
namespace {

constexpr double kLength_m = 400.0;

/// A version and what was done to make it.
struct Candidate {
  std::string name;
  EditableMap map;
};

/// Landmarks from one keyframe to another, moved by `offset_m`.
EditableMap Bent(EditableMap map, float offset_m) {
  const std::size_t count = map.keyframes.size();
  for (std::size_t k = count / 3; k < count * 2 / 3; ++k) {
    for (MapPoint& point : map.keyframes[k].points) point.y_m += offset_m;
  }
  return map;
}

/// Every third landmark is gone.
EditableMap Thinned(EditableMap map) {
  int number = 0;
  for (EditableKeyframe& keyframe : map.keyframes) {
    std::erase_if(keyframe.points, [&](const MapPoint&) { return number++ % 3 == 0; });
  }
  return map;
}

/// Passes whose poses are `offset_m` to the left of where they were localized, not refined.
EditableMap Displaced(const EditableMap& base, std::vector<PlacedPass> passes, double offset_m) {
  for (PlacedPass& pass : passes) {
    for (PlacedScan& scan : pass.scans) {
      scan.T_map_vehicle = scan.T_map_vehicle * Embed(Pose2{{0.0, offset_m}, 0.0});
    }
  }
  MapUpdateOptions options;
  options.alignment.track.pose_sigma_m = 1e-3;
  options.alignment.track.pose_sigma_rad = 1e-4;
  return UpdateMap(base, passes, options).value().map;
}

/// Radars of two vehicles whose mounts are described 1.5 degrees wrong, alike.
EditableMap WronglyMounted(const std::shared_ptr<const RadarMap>& base, Town town) {
  for (std::size_t i = 0; i < 2; ++i) {
    for (RadarModel& radar : town.passes[i].drive.rig.radars) {
      radar.T_vehicle_radar.rotation =
          radar.T_vehicle_radar.rotation * Eigen::AngleAxisd(0.026, Eigen::Vector3d::UnitZ());
    }
  }
  const auto update = UpdateMap(ToEditable(*base), PlacePasses(base, town));
  return update.ok() ? update->map : ToEditable(*base);
}

void Judge(std::uint64_t seed, const Candidate& candidate, const EditableMap& base, double old_m,
           const Town& town, const std::vector<Scan>& scans,
           const std::vector<Eigen::Vector2d>& intermittent_m) {
  const double new_m =
      MedianError_m(RadarMap::FromBytes(ToMapBytes(candidate.map).value()).value(), town.held_out);
  const auto evaluation =
      EvaluateUpdate(base, candidate.map, town.held_out.rig, scans, intermittent_m);
  if (!evaluation.ok()) {
    std::printf("%-5lu %-10s %7.4f %7.4f  refused: %s\n", static_cast<unsigned long>(seed),
                candidate.name.c_str(), old_m, new_m, evaluation.status().ToString().c_str());
    return;
  }
  std::printf("%-5lu %-10s %7.4f %7.4f %7.4f %7.4f %7.4f %-6s %s\n",
              static_cast<unsigned long>(seed), candidate.name.c_str(), old_m, new_m,
              evaluation->whole.old_version.error_m, evaluation->whole.new_version.error_m,
              evaluation->whole.new_version.offset_m, evaluation->is_better ? "passes" : "fails",
              evaluation->reason.c_str());
  std::fflush(stdout);
}

void Run(std::uint64_t first_seed, std::uint64_t last_seed) {
  std::printf("%-5s %-10s %7s %7s %7s %7s %7s\n", "seed", "version", "old", "new", "judged",
              "judged", "offset");
  for (std::uint64_t seed = first_seed; seed <= last_seed; ++seed) {
    const Town town = MakeAgedTown(seed, kLength_m, 1);
    const auto map =
        RadarMap::FromBytes(BuildMap(town.base.drive, {.name = "base"}).value()).value();
    const EditableMap base = ToEditable(*map);
    const std::vector<PlacedPass> passes = PlacePasses(map, town);
    const MapUpdate update = UpdateMap(base, passes).value();
    const EditableMap& updated = update.map;
    const std::vector<Eigen::Vector2d> intermittent_m = IntermittentPlaces(update);
    std::vector<Scan> scans;
    for (const DriveScan& entry : town.held_out.scans) scans.push_back(entry.scan);
    const double old_m = MedianError_m(map, town.held_out);
    for (const Candidate& candidate :
         {Candidate{"update", updated}, Candidate{"bent", Bent(updated, 0.25F)},
          Candidate{"thinned", Thinned(updated)},
          Candidate{"displaced", Displaced(base, passes, 0.25)},
          Candidate{"mounts", WronglyMounted(map, town)}}) {
      Judge(seed, candidate, base, old_m, town, scans, intermittent_m);
    }
  }
}

}  // namespace
}  // namespace dcloc::benchmarks

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: %s FIRST_SEED LAST_SEED\n", argv[0]);
    return 2;
  }
  dcloc::benchmarks::Run(std::strtoull(argv[1], nullptr, 10), std::strtoull(argv[2], nullptr, 10));
  return 0;
}
