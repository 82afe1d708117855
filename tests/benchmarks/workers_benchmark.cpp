// Many vehicles on the server's worker pool, without the transport: how the scans a second grow
// with the workers, and what a tracker waits while others search the whole map.
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <latch>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "core/localizer/localizer.h"
#include "server/base/object_pool.h"
#include "server/base/worker_pool.h"
#include "tests/benchmarks/inputs.h"

namespace dcloc::benchmarks {
namespace {

using Clock = std::chrono::steady_clock;
using server::Lane;
using server::Strand;
using server::WorkerPool;
using WorkspacePool = server::ObjectPool<LocalizerWorkspace>;

double CpuSecondsOfThread() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double SecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

// One vehicle on the live drive, from its beginning.
struct Vehicle {
  Vehicle(const Case& drives, WorkerPool& pool, WorkspacePool& lender, bool with_prior)
      : scans(&drives.live_drive.scans),
        localizer(Make(drives, with_prior)),
        strand(pool),
        workspaces(&lender) {}

  static Localizer Make(const Case& drives, bool with_prior) {
    Vector6d sigmas;
    sigmas << 0.7, 0.7, 0.1, 0.01, 0.01, 0.035;
    std::optional<InitialPose> prior;
    if (with_prior) {
      prior = {drives.live_drive.scans.front().T_map_vehicle, sigmas.cwiseAbs2().asDiagonal()};
    }
    auto made = Localizer::Create(drives.map, drives.live_drive.rig, prior);
    if (!made.ok()) std::abort();  // its inputs are ours
    return *std::move(made);
  }

  // The next scan; on the strand, in a workspace that is lent as the server lends it.
  void Localize() {
    const WorkspacePool::Lease workspace = workspaces->Acquire();
    const double begin_s = CpuSecondsOfThread();
    if (!localizer.Localize((*scans)[next++].scan, *workspace).ok()) std::abort();
    cpu_s += CpuSecondsOfThread() - begin_s;
  }

  bool done() const { return next == scans->size(); }

  const std::vector<DriveScan>* scans;
  Localizer localizer;
  Strand strand;
  WorkspacePool* workspaces;
  std::size_t next = 0;
  double cpu_s = 0.0;
};

struct Throughput {
  double scans_per_s = 0.0;  // by the clock
  double cpu_ms = 0.0;       // a scan
};

// All vehicles' scans as fast as they go.
Throughput Run(const Case& drives, int worker_count, std::size_t vehicle_count) {
  std::vector<std::unique_ptr<Vehicle>> vehicles;
  const std::size_t scan_count = drives.live_drive.scans.size();
  std::latch done(static_cast<std::ptrdiff_t>(vehicle_count * scan_count));
  WorkspacePool workspaces;
  WorkerPool pool(worker_count);
  for (std::size_t i = 0; i < vehicle_count; ++i) {
    vehicles.push_back(std::make_unique<Vehicle>(drives, pool, workspaces, /*with_prior=*/true));
  }
  const Clock::time_point begin = Clock::now();
  for (std::size_t scan = 0; scan < scan_count; ++scan) {
    for (const auto& vehicle : vehicles) {
      vehicle->strand.Post([&done, v = vehicle.get()] {
        v->Localize();
        done.count_down();
      });
    }
  }
  done.wait();
  const double seconds = SecondsSince(begin);
  double cpu_s = 0.0;
  for (const auto& vehicle : vehicles) cpu_s += vehicle->cpu_s;
  const auto count = static_cast<double>(vehicle_count * scan_count);
  return {count / seconds, 1e3 * cpu_s / count};
}

// One and two workers in turn, the best of each: what others do on the machine only ever takes.
void PrintScaling(const Case& drives, bool smoke) {
  constexpr std::size_t kVehicles = 16;
  const int rounds = smoke ? 1 : 5;
  std::array<Throughput, 2> best{{{0.0, 1e9}, {0.0, 1e9}}};
  for (int round = 0; round < rounds; ++round) {
    for (int workers = 1; workers <= 2; ++workers) {
      const Throughput now = Run(drives, workers, smoke ? 2 : kVehicles);
      Throughput& of = best[static_cast<std::size_t>(workers) - 1];
      of.scans_per_s = std::max(of.scans_per_s, now.scans_per_s);
      of.cpu_ms = std::min(of.cpu_ms, now.cpu_ms);
    }
  }
  for (std::size_t i = 0; i < best.size(); ++i) {
    std::printf("%-12s %8zu %12.0f %10.3f %8.2f %12.2f\n", drives.name.c_str(), i + 1,
                best[i].scans_per_s, best[i].cpu_ms, best[i].scans_per_s / best[0].scans_per_s,
                static_cast<double>(i + 1) * best[0].cpu_ms / best[i].cpu_ms);
  }
}

// Latencies of a tracker at 13 Hz on one worker, while `searching_count` others without a prior are
// localized at the same rate, each begun anew when it is found.
std::vector<double> Latencies_ms(const Case& drives, std::size_t searching_count, bool own_lane,
                                 std::size_t scan_count) {
  constexpr std::chrono::milliseconds kInterval(77);
  std::vector<double> latencies_ms(scan_count);
  std::latch done(static_cast<std::ptrdiff_t>(scan_count));
  std::vector<std::unique_ptr<Vehicle>> blind;
  std::vector<std::unique_ptr<std::atomic<bool>>> busy;
  std::unique_ptr<Vehicle> tracker;
  WorkspacePool workspaces;
  WorkerPool pool(1, 1);  // goes first: its tasks use the others
  tracker = std::make_unique<Vehicle>(drives, pool, workspaces, /*with_prior=*/true);
  for (std::size_t i = 0; i < searching_count; ++i) {
    blind.push_back(std::make_unique<Vehicle>(drives, pool, workspaces, /*with_prior=*/false));
    busy.push_back(std::make_unique<std::atomic<bool>>(false));
  }
  const Clock::time_point begin = Clock::now();
  for (std::size_t i = 0; i < scan_count; ++i) {
    std::this_thread::sleep_until(begin + i * kInterval);
    for (std::size_t j = 0; j < searching_count; ++j) {
      if (busy[j]->exchange(true)) continue;
      blind[j]->strand.Post([&drives, own_lane, is_busy = busy[j].get(), v = blind[j].get()] {
        if (v->done() || v->localizer.has_pose()) {
          v->localizer = Vehicle::Make(drives, /*with_prior=*/false);
          v->next = 0;
        }
        v->Localize();
        if (own_lane) v->strand.SetLane(Lane::kLengthy);
        *is_busy = false;
      });
    }
    tracker->strand.Post([&done, &latencies_ms, &tracker, i, posted = Clock::now()] {
      tracker->Localize();
      latencies_ms[i] = 1e3 * SecondsSince(posted);
      done.count_down();
    });
  }
  done.wait();
  return latencies_ms;
}

void PrintLatencies(const char* who, std::vector<double> latencies_ms) {
  // The first ones search around the prior.
  constexpr std::ptrdiff_t kBeginning = 30;
  if (latencies_ms.size() > 2 * kBeginning) {
    latencies_ms.erase(latencies_ms.begin(), latencies_ms.begin() + kBeginning);
  }
  std::ranges::sort(latencies_ms);
  const auto at = [&](double share) {
    return latencies_ms[static_cast<std::size_t>(share *
                                                 static_cast<double>(latencies_ms.size() - 1))];
  };
  std::printf("%-44s %8.2f %8.2f %8.2f\n", who, at(0.5), at(0.99), at(1.0));
}

}  // namespace
}  // namespace dcloc::benchmarks

int main(int argc, char** argv) {
  using namespace dcloc::benchmarks;  // NOLINT(google-build-using-namespace)
  const bool smoke = IsSmokeRun(argc, argv);
  std::array<double, 1> load{};
  if (getloadavg(load.data(), 1) == 1) {
    std::printf("load of the machine before: %.2f on %u processors\n\n", load[0],
                std::thread::hardware_concurrency());
  }
  const double length_m = smoke ? 60.0 : 300.0;
  std::printf("%-12s %8s %12s %10s %8s %12s\n", "case", "workers", "scans/s", "CPU ms", "times",
              "times by CPU");
  for (const char* name : {"ars408", "carla"}) PrintScaling(SimulatedCase(name, length_m), smoke);

  const Case drives = SimulatedCase("ars408", length_m);
  const std::size_t scan_count =
      smoke ? 10 : std::min<std::size_t>(300, drives.live_drive.scans.size());
  std::printf("\n%-44s %8s %8s %8s\n", "latency of a tracker on one worker, ms", "p50", "p99",
              "max");
  PrintLatencies("alone", Latencies_ms(drives, 0, true, scan_count));
  PrintLatencies("20 search the map, in its line", Latencies_ms(drives, 20, false, scan_count));
  PrintLatencies("20 search the map, in a line of their own",
                 Latencies_ms(drives, 20, true, scan_count));
  return 0;
}
