// The whole pipeline, scan by scan: time of this thread, allocations and error while tracking.
#include <malloc.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <numbers>
#include <numeric>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/localizer/localizer.h"
#include "tests/benchmarks/allocations.h"
#include "tests/benchmarks/inputs.h"

namespace dcloc::benchmarks {
namespace {

// This thread's own time, so that a busy machine changes little.
double CpuMilliseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

// Time of each stage of one scan.
class StageClock final : public StageListener {
 public:
  void OnStageBegin(Stage stage) override {
    End();
    running_ = static_cast<std::size_t>(stage);
    begin_ms_ = CpuMilliseconds();
  }
  void End() {
    if (running_) stage_ms_[*running_].push_back(CpuMilliseconds() - begin_ms_);
    running_.reset();
  }
  const std::array<std::vector<double>, kStageNames.size()>& stage_ms() const { return stage_ms_; }

 private:
  std::array<std::vector<double>, kStageNames.size()> stage_ms_;
  std::optional<std::size_t> running_;
  double begin_ms_ = 0.0;
};

// Whether the scan was registered: while tracking, not each one is.
class RegistrationWatch final : public StageListener {
 public:
  void OnStageBegin(Stage stage) override {
    registers_ = registers_ || stage == Stage::kRegistration;
  }
  bool TakeRegisters() { return std::exchange(registers_, false); }

 private:
  bool registers_ = false;
};

struct Figures {
  std::vector<double> scan_ms;
  std::vector<bool> registers;  // of each of them
  std::vector<double> live_points;
  std::vector<double> allocations;
  std::vector<double> errors_m;
  std::vector<double> errors_deg;
  double session_bytes = 0.0;
};

double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return std::nan("");
  const auto nth =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

Pose3 OffBy(const Pose3& T_map_vehicle, double translation_m, double rotation_deg) {
  return T_map_vehicle * Embed(Pose2{.translation_m = {0.6 * translation_m, -0.8 * translation_m},
                                     .yaw_rad = rotation_deg * std::numbers::pi / 180.0});
}

InitialPose Prior(const Pose3& T_map_vehicle_true) {
  Vector6d sigmas;
  sigmas << 0.7, 0.7, 0.1, 0.01, 0.01, 0.035;
  return {OffBy(T_map_vehicle_true, 1.0, 2.0), sigmas.cwiseAbs2().asDiagonal()};
}

// Until the session tracks, it searches: what a scan costs is asked of a tracker.
// The workspace is lent, as the server lends it: it is no part of the session.
Figures Drive(const Case& drives, LocalizerWorkspace& workspace) {
  const auto bytes_before = static_cast<double>(mallinfo2().uordblks);
  auto localizer = Localizer::Create(drives.map, drives.live_drive.rig,
                                     Prior(drives.live_drive.scans.front().T_map_vehicle));
  Figures figures;
  RegistrationWatch watch;
  bool tracking = false;
  for (const auto& [scan, T_map_vehicle] : drives.live_drive.scans) {
    const std::int64_t allocations_before = AllocationCount();
    const double begin_ms = CpuMilliseconds();
    const auto answer = localizer->Localize(scan, workspace, &watch);
    const double scan_ms = CpuMilliseconds() - begin_ms;
    const std::int64_t allocations = AllocationCount() - allocations_before;
    const bool registers = watch.TakeRegisters();
    if (!answer.ok()) continue;
    if (tracking) {
      figures.scan_ms.push_back(scan_ms);
      figures.registers.push_back(registers);
      figures.allocations.push_back(static_cast<double>(allocations));
      figures.live_points.push_back(answer->quality.live_point_count);
      const Pose2 error = Flatten(T_map_vehicle.Inverse() * answer->T_map_vehicle);
      figures.errors_m.push_back(error.translation_m.norm());
      figures.errors_deg.push_back(std::abs(error.yaw_rad) * 180.0 / std::numbers::pi);
    }
    tracking = answer->state == LocalizationState::kTracking;
  }
  figures.session_bytes = static_cast<double>(mallinfo2().uordblks) - bytes_before -
                          static_cast<double>(5 * figures.scan_ms.capacity() * sizeof(double));
  return figures;
}

// Of several runs the fastest of each scan: what others do on the machine only ever adds.
Figures BestOf(const Case& drives, int runs) {
  LocalizerWorkspace workspace;
  Figures best = Drive(drives, workspace);
  for (int run = 1; run < runs; ++run) {
    const Figures again = Drive(drives, workspace);
    // The first run also grows the workspace.
    best.session_bytes = again.session_bytes;
    for (std::size_t i = 0; i < best.scan_ms.size(); ++i) {
      best.scan_ms[i] = std::min(best.scan_ms[i], again.scan_ms[i]);
    }
  }
  return best;
}

std::vector<double> RegisteringMilliseconds(const Figures& figures) {
  std::vector<double> registering_ms;
  for (std::size_t i = 0; i < figures.scan_ms.size(); ++i) {
    if (figures.registers[i]) registering_ms.push_back(figures.scan_ms[i]);
  }
  return registering_ms;
}

double Mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

void Print(const Case& drives, const Figures& figures) {
  std::printf(
      "%-12s %6zu %7.0f %8.3f %8.3f %8.3f %8.3f %8.3f %7.0f %9.0f %9.3f %9.3f %9.3f %9.2f\n",
      drives.name.c_str(), figures.scan_ms.size(), Quantile(figures.live_points, 0.5),
      Mean(figures.scan_ms), Quantile(figures.scan_ms, 0.5),
      Quantile(RegisteringMilliseconds(figures), 0.5), Quantile(figures.scan_ms, 0.99),
      Quantile(figures.scan_ms, 1.0), Quantile(figures.allocations, 0.5),
      figures.session_bytes / 1e3, Quantile(figures.errors_m, 0.5),
      Quantile(figures.errors_m, 0.95), Quantile(figures.errors_deg, 0.5),
      static_cast<double>(drives.map_bytes.size()) / 1e3 / drives.map->info().length_m);
}

// Medians over the scans that have the stage, in a run of its own: reading clocks costs time too.
void PrintStages(const Case& drives) {
  StageClock clock;
  auto localizer = Localizer::Create(drives.map, drives.live_drive.rig,
                                     Prior(drives.live_drive.scans.front().T_map_vehicle));
  for (const auto& [scan, T_map_vehicle] : drives.live_drive.scans) {
    static_cast<void>(localizer->Localize(scan, &clock));
    clock.End();
  }
  std::printf("%-12s", drives.name.c_str());
  for (const std::vector<double>& times_ms : clock.stage_ms()) {
    std::printf(" %12.3f", Quantile(times_ms, 0.5));
  }
  std::printf("\n");
}

}  // namespace
}  // namespace dcloc::benchmarks

int main(int argc, char** argv) {
  using namespace dcloc::benchmarks;  // NOLINT(google-build-using-namespace)
  const std::string only = argc == 3 && std::string_view(argv[1]) == "--only" ? argv[2] : "";
  const bool smoke = only.empty() && IsSmokeRun(argc, argv);
  std::vector<Case> cases;
  for (const char* name : {"ars408", "carla"}) {
    cases.push_back(SimulatedCase(name, smoke ? 60.0 : 500.0));
  }
  if (!smoke) {
    for (Case& recorded : RecordedCases()) cases.push_back(std::move(recorded));
  }
  if (!only.empty()) {
    std::erase_if(cases, [&](const Case& drives) { return drives.name != only; });
    if (cases.empty()) {
      std::fprintf(stderr, "--only is '%s'; there is no such case, or no recording of it\n",
                   only.c_str());
      return 2;
    }
  }
  std::printf("%-12s %6s %7s %8s %8s %8s %8s %8s %7s %9s %9s %9s %9s %9s\n", "case", "scans",
              "points", "mean ms", "p50 ms", "p50 ms", "p99 ms", "max ms", "allocs", "session",
              "error", "error", "error", "map");
  std::printf("%-12s %6s %7s %8s %8s %8s %8s %8s %7s %9s %9s %9s %9s %9s\n", "", "", "p50", "", "",
              "register", "", "", "p50", "kB", "p50 m", "p95 m", "p50 deg", "MB/km");
  bool tracked = true;
  for (const Case& drives : cases) {
    const Figures figures = BestOf(drives, smoke ? 1 : 3);
    Print(drives, figures);
    tracked = tracked && !figures.scan_ms.empty();
  }
  std::printf("\n%-12s", "p50 ms");
  for (const char* stage : dcloc::kStageNames) std::printf(" %12s", stage);
  std::printf("\n");
  for (const Case& drives : cases) PrintStages(drives);
  return tracked ? 0 : 1;
}
