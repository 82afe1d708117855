#include "tests/benchmarks/ageing_town.h"

#include <string>
#include <utility>

#include "client/datasets/drive_map.h"
#include "client/evaluation/metrics.h"
#include "client/evaluation/runner.h"

namespace dcloc::benchmarks {
namespace {

constexpr std::size_t kPassCount = 3;  // of the update; one more is judged

}  // namespace

Town MakeAgedTown(std::uint64_t seed, double length_m, int rig_size) {
  SimulationOptions options;
  options.seed = seed;
  options.length_m = length_m;
  options.rig_size = rig_size;
  options.parked_change_share = 1.0;
  options.vehicle_count = 4;
  options.ageing.replaced_share = 0.1;
  options.live_speeds_mps = {50.0 / 3.6, 40.0 / 3.6, 60.0 / 3.6, 45.0 / 3.6};
  return MakeAgedTown(options);
}

Town MakeAgedTown(const SimulationOptions& options) {
  const std::vector<PassOptions> passes = Passes(options);
  const simulation::World world = MakeWorld(options);
  Town town{.aged = AgeWorld(world, options)};
  town.base = SimulatePassWithTruth(world, options, passes[0]).value();
  for (std::size_t i = 1; i <= kPassCount; ++i) {
    town.passes.push_back(SimulatePassWithTruth(town.aged.world, options, passes[i]).value());
  }
  town.held_out =
      SimulatePassWithTruth(town.aged.world, options, passes[kPassCount + 1]).value().drive;
  return town;
}

std::vector<PlacedPass> PlacePasses(const std::shared_ptr<const RadarMap>& base, const Town& town) {
  std::vector<PlacedPass> placed;
  for (const SimulatedPass& pass : town.passes) {
    auto placer =
        PassPlacer::Create(base, pass.drive.name, std::to_string(pass.vehicle), pass.drive.rig);
    for (const DriveScan& scan : pass.drive.scans) placer->Add(scan.scan);
    placed.push_back(std::move(*placer).Finish());
  }
  return placed;
}

std::shared_ptr<const RadarMap> MadeAnew(const Town& town) {
  Drive all = town.passes.front().drive;
  for (std::size_t i = 1; i < town.passes.size(); ++i) {
    const Drive& drive = town.passes[i].drive;
    for (RadarModel radar : drive.rig.radars) {
      radar.id += "@" + drive.name;
      all.rig.radars.push_back(radar);
    }
    for (DriveScan scan : drive.scans) {
      scan.scan.radar_id += "@" + drive.name;
      all.scans.push_back(std::move(scan));
    }
  }
  return RadarMap::FromBytes(BuildMap(all, {.name = "anew"}).value()).value();
}

double MedianError_m(const std::shared_ptr<const RadarMap>& map, const Drive& drive) {
  const DriveOutcome outcome = Evaluate(map, drive, {}, [](double) {}).value();
  return ComputeMetrics({&outcome, 1}).rte_m.median;
}

}  // namespace dcloc::benchmarks
