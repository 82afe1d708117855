// What ticks of wheels and gyroscope between two scans bring: drives with curves and halts in
// simulated towns, localized with one velocity a scan and with ticks beside it, at several rates of
// scans.
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "client/cli/remote/wire.h"
#include "client/datasets/drive_map.h"
#include "client/evaluation/metrics.h"
#include "client/evaluation/runner.h"
#include "client/simulation/simulation.h"
#include "core/geometry/degrees.h"
#include "tests/benchmarks/inputs.h"
#include "tests/benchmarks/ticked_drive.h"

namespace dcloc::benchmarks {
namespace {

constexpr int kBusRate_hz = 100;

/// A town that was mapped, and a drive through it with what its bus said.
struct TownDrive {
  std::shared_ptr<const RadarMap> map;
  SimulatedPass live;
};

/// What a rate of scans and one of ticks came to, over all drives.
struct Row {
  std::vector<DriveOutcome> outcomes;
  double duration_s = 0.0;
  std::size_t wire_bytes = 0;
};

TownDrive DriveThroughTown(std::uint64_t seed, double length_m) {
  SimulationOptions options;
  options.length_m = length_m;
  options.seed = seed;
  options.stops = true;
  options.signal_rate_hz = kBusRate_hz;
  const auto passes = Passes(options);
  const simulation::World world = MakeWorld(options);
  const SimulatedPass map_pass = SimulatePassWithTruth(world, options, passes[0]).value();
  return {RadarMap::FromBytes(BuildMap(map_pass.drive, {.name = "town"}).value()).value(),
          SimulatePassWithTruth(world, options, passes[1]).value()};
}

/// How much the vehicle turned and for how long it stood, so that a reader knows the drives.
void PrintDrives(const std::vector<TownDrive>& towns) {
  double turned_deg = 0.0;
  double stood_s = 0.0;
  double took_s = 0.0;
  for (const TownDrive& town : towns) {
    const auto& signals = town.live.signals;
    for (std::size_t i = 1; i < signals.size(); ++i) {
      const Pose3 way = signals[i - 1].T_map_vehicle.Inverse() * signals[i].T_map_vehicle;
      turned_deg += std::abs(Flatten(way).yaw_rad) * kDegPerRad;
      if (way.translation_m.norm() < 1e-4) stood_s += 1.0 / kBusRate_hz;
      took_s += 1.0 / kBusRate_hz;
    }
  }
  std::printf("%zu drives, %.0f s; turned by %.0f degrees, stood for %.0f s\n", towns.size(),
              took_s, turned_deg, stood_s);
}

void Localize(const TownDrive& town, double scan_rate_hz, int tick_rate_hz, Row& row) {
  const Drive drive =
      TickedDrive(town.live, scan_rate_hz, tick_rate_hz == 0 ? 0 : kBusRate_hz / tick_rate_hz);
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    row.wire_bytes +=
        cli::ToProto(drive.scans[i].scan, static_cast<std::int64_t>(i)).ByteSizeLong();
  }
  row.duration_s +=
      std::chrono::duration<double>(drive.scans.back().scan.stamp - drive.scans.front().scan.stamp)
          .count();
  absl::StatusOr<DriveOutcome> outcome = Evaluate(town.map, drive, {});
  if (!outcome.ok()) {
    std::cerr << outcome.status() << '\n';
    std::exit(1);
  }
  row.outcomes.push_back(*std::move(outcome));
}

void Print(const char* scans, const char* ticks, const Row& row) {
  const Metrics metrics = ComputeMetrics(row.outcomes);
  const auto tracking = static_cast<double>(
      metrics.state_counts[static_cast<std::size_t>(LocalizationState::kTracking)]);
  std::printf("%-10s %-14s %6zu %8.3f %8.3f %8.3f %8.3f %6.2f %9.1f %8zu %9.0f\n", scans, ticks,
              metrics.scan_count, metrics.rte_m.median, metrics.rte_m.p95, metrics.rre_deg.median,
              metrics.rre_deg.p95, metrics.anees,
              100.0 * tracking / static_cast<double>(metrics.scan_count), metrics.misleading_count,
              static_cast<double>(row.wire_bytes) / row.duration_s);
}

}  // namespace
}  // namespace dcloc::benchmarks

int main(int argc, char** argv) {
  using namespace dcloc::benchmarks;  // NOLINT(google-build-using-namespace)
  const bool smoke = IsSmokeRun(argc, argv);
  constexpr std::uint64_t kFirstSeed = 41;
  std::vector<TownDrive> towns;
  for (std::uint64_t i = 0; i < (smoke ? 1U : 8U); ++i) {
    towns.push_back(DriveThroughTown(kFirstSeed + i, smoke ? 150.0 : 600.0));
  }
  PrintDrives(towns);
  std::printf("%-10s %-14s %6s %8s %8s %8s %8s %6s %9s %8s %9s\n", "scans", "ticks", "scans",
              "p50 m", "p95 m", "p50 deg", "p95 deg", "ANEES", "TRACKING%", "wrong", "bytes/s");
  for (const double scan_rate_hz : {14.0, 4.0, 2.0}) {
    for (const int tick_rate_hz : {0, 50, 100}) {
      Row row;
      for (const TownDrive& town : towns) Localize(town, scan_rate_hz, tick_rate_hz, row);
      const std::string scans = scan_rate_hz > 13.0
                                    ? "all, 13 Hz"
                                    : std::to_string(static_cast<int>(scan_rate_hz)) + " Hz";
      const std::string ticks = tick_rate_hz == 0 ? "none" : std::to_string(tick_rate_hz) + " Hz";
      Print(scans.c_str(), ticks.c_str(), row);
    }
  }
}
