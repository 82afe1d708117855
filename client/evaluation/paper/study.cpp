#include "client/evaluation/paper/study.h"

#include <algorithm>
#include <map>
#include <memory>
#include <tuple>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/datasets/drive_calibration.h"
#include "client/evaluation/baselines/map_for_method.h"
#include "client/evaluation/paper/speed_difference.h"

namespace dcloc::paper {
namespace {

using Map = std::shared_ptr<const RadarMap>;

void AddOnce(const Variant& variant, Protocol protocol, std::vector<Run>& runs) {
  const bool is_known = std::ranges::any_of(
      runs, [&](const Run& run) { return run.variant == variant && run.protocol == protocol; });
  if (!is_known) runs.push_back({variant, protocol});
}

void AddAblations(bool quick, std::vector<Run>& runs) {
  for (const MethodKind method : {MethodKind::kDcLocPlusPlus, MethodKind::kDcloc}) {
    for (const RowPlan& row : Table2Rows(method)) {
      if (quick && row.variant.uncertainty != row.variant.truncation) continue;
      AddOnce(row.variant, Protocol::kTrack, runs);
    }
  }
  for (const RowPlan& row : Table3Rows()) {
    if (quick && row.variant.scans_per_submap > 5) continue;
    AddOnce(row.variant, Protocol::kTrack, runs);
  }
}

EvaluationOptions ToOptions(const Case& item, const Run& run) {
  EvaluationOptions options{.method = run.variant.method, .protocol = run.protocol};
  options.query_interval_s = item.query_interval_s;
  if (run.variant.far_prior) options.perturbation = {.translation_m = 3.0, .rotation_deg = 5.0};
  const bool is_pcl =
      run.variant.method == MethodKind::kIcp || run.variant.method == MethodKind::kNdt;
  if (is_pcl && run.protocol == Protocol::kTrack) {
    options.localizer.schedule.interval = kPclRegistrationInterval;
  }
  options.localizer.doppler_compensation = run.variant.doppler;
  options.localizer.per_point_covariance = run.variant.uncertainty;
  options.localizer.gate_outliers = run.variant.truncation;
  options.localizer.scans_per_submap = run.variant.scans_per_submap;
  return options;
}

absl::StatusOr<Calibration> Calibrate(const std::vector<Drive>& drives) {
  auto calibrator = Calibrator::Create(drives.front().rig);
  if (!calibrator.ok()) return calibrator.status();
  for (const Drive& drive : drives) {
    if (absl::Status status = AddDrive(drive, *calibrator); !status.ok()) return status;
  }
  return calibrator->Estimate();
}

absl::Status Apply(const Calibration& calibration, Drive& drive) {
  for (RadarModel& radar : drive.rig.radars) {
    const auto found =
        std::ranges::find(calibration.radars, radar.id,
                          [](const RadarCalibration& entry) { return entry.described.id; });
    if (found == calibration.radars.end()) {
      return absl::NotFoundError(absl::StrCat("the calibration has no radar ", radar.id));
    }
    radar = Calibrated(*found);
  }
  return absl::OkStatus();
}

/// The drives of a case and the maps made of them so far. Drives are not loaded before the first
/// run that needs them.
class Workbench {
 public:
  explicit Workbench(const Case& item) : case_(item) {}

  absl::StatusOr<DriveOutcome> Do(const Run& run, const std::function<void(double)>& progress) {
    absl::Status status = Load();
    if (status.ok() && run.variant.calibrated) status = LoadCalibrated();
    if (!status.ok()) return status;
    const EvaluationOptions options = ToOptions(case_, run);
    const auto map = MapFor(run.variant, options.localizer);
    if (!map.ok()) return map.status();
    auto outcome = Evaluate(*map, DrivesFor(run.variant).live, options, progress);
    if (!outcome.ok()) return outcome.status();
    for (ScanOutcome& scan : outcome->scans) {
      scan.speed_difference_mps = speeds_->At(scan.answer.stamp);
    }
    outcome->map = nullptr;
    return outcome;
  }

  /// The run that gives the same: without a range-Doppler coupling there is nothing to compensate.
  absl::StatusOr<Run> Equivalent(Run run) {
    if (absl::Status status = Load(); !status.ok()) return status;
    const auto has_coupling = [](const RadarModel& radar) { return radar.beta_s != 0.0; };
    if (std::ranges::none_of(drives_->map.rig.radars, has_coupling) &&
        std::ranges::none_of(drives_->live.rig.radars, has_coupling)) {
      run.variant.doppler = true;
    }
    return run;
  }

 private:
  absl::Status Load() {
    if (drives_) return absl::OkStatus();
    auto loaded = case_.load();
    if (!loaded.ok()) return loaded.status();
    drives_ = *std::move(loaded);
    speeds_ = std::make_unique<SpeedDifferences>(drives_->map, drives_->live);
    return absl::OkStatus();
  }

  absl::Status LoadCalibrated() {
    if (calibrated_) return absl::OkStatus();
    const auto drives = case_.load_calibration();
    if (!drives.ok()) return drives.status();
    const auto calibration = Calibrate(*drives);
    if (!calibration.ok()) return calibration.status();
    calibrated_ = drives_;
    absl::Status status = Apply(*calibration, calibrated_->map);
    status.Update(Apply(*calibration, calibrated_->live));
    return status;
  }

  const DrivePair& DrivesFor(const Variant& variant) const {
    return variant.calibrated ? *calibrated_ : *drives_;
  }

  absl::StatusOr<Map> MapFor(const Variant& variant, const LocalizerOptions& options) {
    Map& map = maps_[{variant.method, variant.doppler, variant.uncertainty, variant.calibrated}];
    if (map == nullptr) {
      auto made = MapForMethod(variant.method, DrivesFor(variant).map, options);
      if (!made.ok()) return made.status();
      map = *std::move(made);
    }
    return map;
  }

  const Case& case_;
  std::optional<DrivePair> drives_;
  std::optional<DrivePair> calibrated_;  // the same with the calibrated rig
  std::unique_ptr<SpeedDifferences> speeds_;
  std::map<std::tuple<MethodKind, bool, bool, bool>, Map> maps_;
};

/// The outcome of `run`, of `store` or done now.
absl::StatusOr<DriveOutcome> Obtain(const Case& item, const Run& run, Workbench& workbench,
                                    ResultStore<DriveOutcome>& store,
                                    const std::function<void(double)>& progress) {
  const std::string name = RunName(item, run);
  if (auto outcome = store.Load(name)) return *std::move(outcome);
  const auto same = workbench.Equivalent(run);
  if (!same.ok()) return same.status();
  auto outcome = same->variant == run.variant ? workbench.Do(run, progress)
                                              : Obtain(item, *same, workbench, store, progress);
  if (!outcome.ok()) return outcome.status();
  if (absl::Status status = store.Save(name, *outcome); !status.ok()) return status;
  return outcome;
}

}  // namespace

std::vector<Run> PlanRuns(const Case& item, bool quick) {
  std::vector<Run> runs;
  if (item.purpose == Purpose::kNoise) {
    for (const RowPlan& row : NoiseRows()) AddOnce(row.variant, Protocol::kTrack, runs);
  } else {
    for (const RowPlan& row : Table1Rows()) {
      AddOnce(row.variant, Protocol::kTrack, runs);
      AddOnce(row.variant, Protocol::kPairs, runs);
    }
    AddOnce({.calibrated = true, .far_prior = true}, Protocol::kPairs, runs);
  }
  if (!item.load_calibration) {
    std::erase_if(runs, [](const Run& run) { return run.variant.calibrated; });
  }
  if (item.purpose == Purpose::kAblations) AddAblations(quick, runs);
  return runs;
}

std::string RunName(const Case& item, const Run& run) {
  return absl::StrCat(item.name, ".", VariantName(run.variant), ".",
                      run.protocol == Protocol::kTrack ? "track" : "pairs");
}

absl::StatusOr<std::vector<RunResult>> RunStudy(
    const std::vector<Case>& cases, bool quick, ResultStore<DriveOutcome>& store,
    const std::function<void(const std::string&, double)>& progress) {
  std::size_t total = 0;
  for (const Case& item : cases) total += PlanRuns(item, quick).size();
  std::vector<RunResult> results;
  for (const Case& item : cases) {
    Workbench workbench(item);
    for (const Run& run : PlanRuns(item, quick)) {
      const std::string name = RunName(item, run);
      const auto tell = [&](double share) {
        progress(name, (static_cast<double>(results.size()) + share) / static_cast<double>(total));
      };
      tell(0.0);
      auto outcome = Obtain(item, run, workbench, store, tell);
      if (!outcome.ok()) {
        return absl::Status(outcome.status().code(),
                            absl::StrCat(name, ": ", outcome.status().message()));
      }
      results.push_back({item.set, item.name, run.variant, run.protocol, *std::move(outcome)});
    }
  }
  return results;
}

}  // namespace dcloc::paper
