// A map of a part of a town's ring, updated by passes that drove all of it: how well vehicles are
// then localized where the map did not reach, beside a map made at the true poses of the passes.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "client/datasets/drive_map.h"
#include "client/evaluation/metrics.h"
#include "client/evaluation/runner.h"
#include "client/simulation/simulation.h"
#include "core/passes/pass_alignment.h"
#include "core/update/map_update.h"
#include "core/versions/judged_version.h"
#include "tests/benchmarks/ageing_town.h"

namespace dcloc::benchmarks {
namespace {

constexpr double kWrong_m = 2.0;

/// What is asked for: `--seeds FIRST LAST`, the lap and how much of it the map has.
struct Arguments {
  std::uint64_t first_seed = 1;
  std::uint64_t last_seed = 5;
  double lap_m = 900.0;
  double mapped_m = 400.0;
  int rig_size = 1;
};

Town MakeTown(const Arguments& arguments, std::uint64_t seed) {
  SimulationOptions options;
  options.seed = seed;
  options.rig_size = arguments.rig_size;
  options.length_m = 1.3 * arguments.lap_m;
  options.loop_m = arguments.lap_m;
  options.parked_change_share = 1.0;
  options.vehicle_count = 4;
  options.live_speeds_mps = {50.0 / 3.6, 40.0 / 3.6, 60.0 / 3.6, 45.0 / 3.6};
  Town town = MakeAgedTown(options);
  const Eigen::Vector3d begin_m = town.base.drive.scans.front().T_map_vehicle.translation_m;
  double way_m = 0.0;
  Eigen::Vector3d last_m = begin_m;
  std::size_t count = 0;
  for (const DriveScan& scan : town.base.drive.scans) {
    way_m += (scan.T_map_vehicle.translation_m - last_m).norm();
    last_m = scan.T_map_vehicle.translation_m;
    if (way_m > arguments.mapped_m) break;
    ++count;
  }
  town.base.drive.scans.resize(count);
  return town;
}

/// Median and largest error of a pass beyond the map.
std::string ErrorsBeyond(const PlacedPass& pass, const std::vector<DriveScan>& truth) {
  std::vector<double> errors_m = {0.0};
  std::size_t i = 0;
  for (const PlacedScan& scan : pass.scans) {
    while (truth[i].scan.stamp < scan.stamp) ++i;
    if (!scan.is_good || !scan.is_beyond_map) continue;
    const Eigen::Vector3d& p_m = truth[i].T_map_vehicle.translation_m;
    errors_m.push_back((scan.T_map_vehicle.translation_m - p_m).head<2>().norm());
  }
  std::ranges::sort(errors_m);
  return absl::StrFormat("%.2f (%.2f)", errors_m[errors_m.size() / 2], errors_m.back());
}

/// How a drive fares where `base` has no keyframe within 20 m.
struct Beyond {
  std::size_t scans = 0, tracking = 0, wrong = 0;
  double median_m = 0.0, p95_m = 0.0;
};

Beyond LocalizeBeyond(const std::shared_ptr<const RadarMap>& map, const RadarMap& base,
                      const Drive& drive) {
  Beyond beyond;
  std::vector<double> errors_m;
  auto localizer = Localizer::Create(map, drive.rig, std::nullopt).value();
  for (const DriveScan& entry : drive.scans) {
    const auto answer = localizer.Localize(entry.scan);
    if (!answer.ok()) continue;
    const Eigen::Vector3d& p_m = entry.T_map_vehicle.translation_m;
    if (!base.KeyframesWithin(p_m, 20.0).empty()) continue;
    ++beyond.scans;
    if (answer->state != LocalizationState::kTracking) continue;
    ++beyond.tracking;
    errors_m.push_back((answer->T_map_vehicle.translation_m - p_m).head<2>().norm());
    beyond.wrong += errors_m.back() > kWrong_m ? 1 : 0;
  }
  if (errors_m.empty()) return beyond;
  std::ranges::sort(errors_m);
  beyond.median_m = errors_m[errors_m.size() / 2];
  beyond.p95_m = errors_m[errors_m.size() * 95 / 100];
  return beyond;
}

void Print(const char* map, const Beyond& beyond) {
  std::printf("  %-8s %6zu scans, TRACKING %5.1f %%, wrong %zu, median %.3f m, p95 %.3f m\n", map,
              beyond.scans,
              100.0 * static_cast<double>(beyond.tracking) /
                  static_cast<double>(std::max<std::size_t>(1, beyond.scans)),
              beyond.wrong, beyond.median_m, beyond.p95_m);
}

void Run(const Arguments& arguments) {
  for (std::uint64_t seed = arguments.first_seed; seed <= arguments.last_seed; ++seed) {
    const Town town = MakeTown(arguments, seed);
    const auto base = *RadarMap::FromBytes(BuildMap(town.base.drive, {.name = "base"}).value());
    const std::vector<PlacedPass> placed = PlacePasses(base, town);
    const EditableMap before = ToEditable(*base);
    const MapUpdate update = UpdateMap(before, placed).value();
    const auto updated = RadarMap::FromBytes(ToMapBytes(update.map).value()).value();
    std::printf("seed %llu: %.0f m joined, %.0f m unproven\n",
                static_cast<unsigned long long>(seed), update.new_streets.joined_m,
                update.new_streets.unproven_m);
    std::vector<PlacedPass> aligned = placed;
    AlignPasses(LandmarksOf(before), before.Origin_m(), {}, aligned);
    for (std::size_t i = 0; i < placed.size(); ++i) {
      const std::vector<DriveScan>& truth = town.passes[i].drive.scans;
      std::printf("  %s: %zu scans tracked, %zu beyond, off by %s m by odometry, %s m aligned\n",
                  placed[i].name.c_str(), placed[i].GoodCount(), placed[i].BeyondCount(),
                  ErrorsBeyond(placed[i], truth).c_str(), ErrorsBeyond(aligned[i], truth).c_str());
    }
    Print("before", LocalizeBeyond(base, *base, town.held_out));
    Print("updated", LocalizeBeyond(updated, *base, town.held_out));
    Print("anew", LocalizeBeyond(MadeAnew(town), *base, town.held_out));
    std::vector<Scan> scans;
    for (const DriveScan& entry : town.held_out.scans) scans.push_back(entry.scan);
    const auto judged = JudgeVersion(before, update, town.held_out.rig, scans).value();
    std::printf("  gate: %s, %s%s\n", judged.evaluation.is_better ? "passed" : "refused",
                judged.evaluation.reason.c_str(),
                judged.has_only_new_streets ? "; only new streets" : "");
    const auto written = RadarMap::FromBytes(ToMapBytes(judged.map).value()).value();
    Print("written", LocalizeBeyond(written, *base, town.held_out));
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace dcloc::benchmarks

int main(int argc, char** argv) {
  dcloc::benchmarks::Arguments arguments;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--seeds" && i + 2 < argc) {
      arguments.first_seed = std::strtoull(argv[++i], nullptr, 10);
      arguments.last_seed = std::strtoull(argv[++i], nullptr, 10);
    } else if (argument == "--lap" && i + 2 < argc) {
      arguments.lap_m = std::atof(argv[++i]);
      arguments.mapped_m = std::atof(argv[++i]);
    } else if (argument == "--rig" && i + 1 < argc) {
      arguments.rig_size = std::atoi(argv[++i]);
    } else {
      std::fprintf(stderr, "usage: %s [--seeds FIRST LAST] [--lap LAP_M MAPPED_M] [--rig 1|5]\n",
                   argv[0]);
      return 2;
    }
  }
  dcloc::benchmarks::Run(arguments);
  return 0;
}
