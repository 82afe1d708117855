#include "client/evaluation/paper/study.h"

#include <algorithm>
#include <map>
#include <memory>
#include <tuple>
#include <utility>

#include "absl/strings/str_cat.h"
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
  options.localizer.doppler_compensation = run.variant.doppler;
  options.localizer.uncertainty = run.variant.uncertainty;
  options.localizer.truncation = run.variant.truncation;
  options.localizer.scans_per_submap = run.variant.scans_per_submap;
  return options;
}

/// The drives of a case and the maps made of them so far. Drives are not loaded before the first
/// run that needs them.
class Workbench {
 public:
  explicit Workbench(const Case& item) : case_(item) {}

  absl::StatusOr<DriveOutcome> Do(const Run& run, const std::function<void(double)>& progress) {
    if (!drives_) {
      auto loaded = case_.load();
      if (!loaded.ok()) return loaded.status();
      drives_ = *std::move(loaded);
      speeds_ = std::make_unique<SpeedDifferences>(drives_->map, drives_->live);
    }
    const EvaluationOptions options = ToOptions(case_, run);
    const auto map = MapFor(run.variant, options.localizer);
    if (!map.ok()) return map.status();
    auto outcome = Evaluate(*map, drives_->live, options, progress);
    if (!outcome.ok()) return outcome.status();
    for (ScanOutcome& scan : outcome->scans) {
      scan.speed_difference_mps = speeds_->At(scan.answer.stamp);
    }
    outcome->map = nullptr;
    return outcome;
  }

 private:
  absl::StatusOr<Map> MapFor(const Variant& variant, const LocalizerOptions& options) {
    Map& map =
        maps_[{variant.method == MethodKind::kMcRansac, variant.doppler, variant.uncertainty}];
    if (map == nullptr) {
      auto made = MapForMethod(variant.method, drives_->map, options);
      if (!made.ok()) return made.status();
      map = *std::move(made);
    }
    return map;
  }

  const Case& case_;
  std::optional<DrivePair> drives_;
  std::unique_ptr<SpeedDifferences> speeds_;
  std::map<std::tuple<bool, bool, bool>, Map> maps_;
};

}  // namespace

std::vector<Run> PlanRuns(const Case& item, bool quick) {
  std::vector<Run> runs;
  if (item.purpose == Purpose::kNoise) {
    for (const RowPlan& row : NoiseRows()) runs.push_back({row.variant, Protocol::kTrack});
    return runs;
  }
  for (const RowPlan& row : Table1Rows()) {
    for (const Protocol protocol : {Protocol::kTrack, Protocol::kPairs}) {
      runs.push_back({row.variant, protocol});
    }
  }
  if (item.purpose == Purpose::kAblations) AddAblations(quick, runs);
  return runs;
}

std::string RunName(const Case& item, const Run& run) {
  return absl::StrCat(item.name, ".", VariantName(run.variant), ".",
                      run.protocol == Protocol::kTrack ? "track" : "pairs");
}

absl::StatusOr<std::vector<RunResult>> RunStudy(
    const std::vector<Case>& cases, bool quick, RunStore& store,
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
      std::optional<DriveOutcome> outcome = store.Load(name);
      if (!outcome) {
        auto made = workbench.Do(run, tell);
        if (!made.ok()) {
          return absl::Status(made.status().code(),
                              absl::StrCat(name, ": ", made.status().message()));
        }
        if (absl::Status status = store.Save(name, *made); !status.ok()) return status;
        outcome = *std::move(made);
      }
      results.push_back({item.set, item.name, run.variant, run.protocol, *std::move(outcome)});
    }
  }
  return results;
}

}  // namespace dcloc::paper
