#include "client/cli/evaluate/evaluate_run.h"

#include <algorithm>
#include <memory>
#include <span>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "client/cli/common/atomic_file.h"
#include "client/cli/common/progress.h"
#include "client/cli/common/terminal.h"
#include "client/evaluation/baselines/map_for_method.h"
#include "client/evaluation/metrics_format.h"
#include "client/evaluation/outcome_trajectory.h"
#include "client/evaluation/report.h"
#include "client/trajectory/file_of_drive.h"

namespace dcloc::cli {
namespace {

using Drives = std::vector<Drive>;

using Outcomes = std::vector<DriveOutcome>;

bool IsWithout(const EvaluateArguments& arguments, const std::string& part) {
  return std::ranges::find(arguments.without, part) != arguments.without.end();
}

double CustomaryQueryInterval_s(DatasetFormat format) {
  return format == DatasetFormat::kNuScenes ? 0.5 : 1.0;
}

absl::StatusOr<EvaluationOptions> ToOptions(const EvaluateArguments& arguments) {
  const absl::StatusOr<DatasetFormat> format = DatasetFormatByName(arguments.dataset.format);
  if (!format.ok()) return format.status();
  EvaluationOptions options = arguments.options;
  for (const auto& [name, kind] : kMethodNames) {
    if (arguments.method == name) options.method = kind;
  }
  options.protocol = arguments.protocol == "pairs" ? Protocol::kPairs : Protocol::kTrack;
  options.has_initial_pose = arguments.initial == "truth";
  options.doppler_ego_velocity = arguments.ego_velocity == "doppler";
  options.query_interval_s = arguments.query_interval_s.value_or(CustomaryQueryInterval_s(*format));
  options.localizer.doppler_compensation = !IsWithout(arguments, "doppler");
  options.localizer.per_point_covariance = !IsWithout(arguments, "uncertainty");
  options.localizer.gate_outliers = !IsWithout(arguments, "truncation");
  options.map_heights = !IsWithout(arguments, "heights");
  return options;
}

absl::StatusOr<Drives> ReadDrives(const DatasetArguments& dataset,
                                  const std::vector<std::string>& names, DriveRequest request) {
  Drives drives;
  for (const std::string& name : names) {
    request.name = name;
    auto drive = ReadDrive(dataset, request);
    if (!drive.ok()) return drive.status();
    const absl::Status status = CheckHasReference(*drive, "an evaluation");
    if (!status.ok()) return status;
    drives.push_back(*std::move(drive));
  }
  return drives;
}

// One map drive for all drives, or one for each.
absl::StatusOr<Drives> ReadMapDrives(const EvaluateArguments& arguments) {
  const std::size_t count = arguments.map_drives.size();
  if (count != 1 && count != arguments.drives.size()) {
    return absl::InvalidArgumentError(
        absl::StrFormat("--map-drive names %d drives, --drive %d: give one map drive for all, or "
                        "one for each",
                        count, arguments.drives.size()));
  }
  DriveRequest request = arguments.map;
  if (!request.beta_s.has_value()) request.beta_s = arguments.live.beta_s;
  if (request.rig_file.empty()) request.rig_file = arguments.live.rig_file;
  return ReadDrives(arguments.dataset, arguments.map_drives, request);
}

absl::StatusOr<std::shared_ptr<const RadarMap>> MakeMap(const Drive& drive,
                                                        const EvaluationOptions& options) {
  Progress progress(absl::StrCat("mapping ", drive.name), drive.scans.size());
  return MapForMethod(options.method, drive, options.localizer, options.map_heights,
                      [&](std::size_t scan_count) { progress.Update(scan_count); });
}

absl::StatusOr<Outcomes> EvaluateAll(const Drives& map_drives, const Drives& drives,
                                     const EvaluationOptions& options) {
  std::shared_ptr<const RadarMap> map;
  Outcomes outcomes;
  for (std::size_t i = 0; i < drives.size(); ++i) {
    if (i < map_drives.size()) {
      auto made = MakeMap(map_drives[i], options);
      if (!made.ok()) return made.status();
      map = *std::move(made);
    }
    Progress progress(absl::StrCat("localizing ", drives[i].name));
    auto outcome =
        Evaluate(map, drives[i], options, [&](double share) { progress.UpdateShare(share); });
    if (!outcome.ok()) return outcome.status();
    outcomes.push_back(*std::move(outcome));
  }
  return outcomes;
}

nlohmann::ordered_json ToJson(const Outcomes& outcomes) {
  nlohmann::ordered_json json = MetricsJson(ComputeMetrics(outcomes));
  json["drives"] = nlohmann::ordered_json::array();
  for (const DriveOutcome& outcome : outcomes) {
    nlohmann::ordered_json drive = {{"drive", outcome.drive}};
    drive.update(MetricsJson(ComputeMetrics({&outcome, 1})));
    json["drives"].push_back(std::move(drive));
  }
  return json;
}

void Print(const Outcomes& outcomes) {
  std::vector<std::pair<std::string, Metrics>> columns;
  columns.reserve(outcomes.size() + 1);
  for (const DriveOutcome& outcome : outcomes) {
    columns.emplace_back(outcome.drive, ComputeMetrics({&outcome, 1}));
  }
  if (outcomes.size() > 1) columns.emplace_back("all", ComputeMetrics(outcomes));
  absl::PrintF("%s", FormatTable(MetricsRows(columns)));
  for (const DriveOutcome& outcome : outcomes) {
    if (outcome.refused_count == 0) continue;
    absl::PrintF("%s: %d scans were refused, the first because %s\n", outcome.drive,
                 outcome.refused_count, outcome.first_refusal);
  }
}

absl::Status WriteText(const std::string& file, const std::string& text) {
  if (file.empty()) return absl::OkStatus();
  return WriteFileAtomically(file, std::as_bytes(std::span(text)));
}

/// To the file itself, or of several drives to "FILE-DRIVE.EXTENSION" each.
absl::Status WriteTrajectories(const EvaluateArguments& arguments, const Outcomes& outcomes) {
  absl::Status status;
  for (const DriveOutcome& outcome : outcomes) {
    TrajectoryArguments trajectory = arguments.trajectory;
    if (outcomes.size() > 1 && !trajectory.file.empty()) {
      trajectory.file = FileOfDrive(trajectory.file, outcome.drive);
    }
    status.Update(WriteTrajectory(trajectory, TrajectoryOf(outcome, arguments.anchor)));
  }
  return status;
}

bool HasCoupling(const Drive& drive) {
  return std::ranges::any_of(drive.rig.radars,
                             [](const RadarModel& radar) { return radar.beta_s != 0.0; });
}

std::string Radars(const Drive& drive) {
  return absl::StrJoin(drive.rig.radars, ", ", [](std::string* out, const RadarModel& radar) {
    absl::StrAppendFormat(out, "%s (beta %g s)", radar.id, radar.beta_s);
  });
}

const char* RunLabel(const EvaluationOptions& options) {
  return options.localizer.doppler_compensation ? "with Doppler compensation"
                                                : "without Doppler compensation";
}

std::vector<std::pair<std::string, std::string>> Settings(const EvaluateArguments& arguments,
                                                          const Drives& map_drives,
                                                          const Drives& drives) {
  const Perturbation& perturbation = arguments.options.perturbation;
  const std::string initial =
      arguments.initial == "none"
          ? "none, the whole map is searched"
          : absl::StrFormat("truth moved by %g m and turned by %g deg, seed %d",
                            perturbation.translation_m, perturbation.rotation_deg,
                            perturbation.seed);
  return {{"Data set", arguments.dataset.format},
          {"Map", absl::StrCat(absl::StrJoin(arguments.map_drives, ", "), ", ",
                               Radars(map_drives.front()))},
          {"Localized",
           absl::StrCat(absl::StrJoin(arguments.drives, ", "), ", ", Radars(drives.front()))},
          {"Method", arguments.method},
          {"Protocol", arguments.protocol},
          {"Initial pose", initial},
          {"Ego-velocity", arguments.ego_velocity},
          {"Scans per sub-map", absl::StrCat(arguments.options.localizer.scans_per_submap)},
          {"Switched off",
           arguments.without.empty() ? "nothing" : absl::StrJoin(arguments.without, ", ")}};
}

// The report's second run is the one with the Doppler compensation the other way.
absl::Status WriteReportFile(const EvaluateArguments& arguments, const Drives& map_drives,
                             const Drives& drives, const EvaluationOptions& options,
                             Outcomes outcomes) {
  Report report{.title = absl::StrCat("Localization in the map of ",
                                      absl::StrJoin(arguments.map_drives, ", ")),
                .settings = Settings(arguments, map_drives, drives),
                .note = "",
                .runs = {{RunLabel(options), std::move(outcomes)}},
                .is_track = options.protocol == Protocol::kTrack};
  if (std::ranges::any_of(map_drives, HasCoupling) || std::ranges::any_of(drives, HasCoupling)) {
    EvaluationOptions other = options;
    other.localizer.doppler_compensation = !options.localizer.doppler_compensation;
    auto compared = EvaluateAll(map_drives, drives, other);
    if (!compared.ok()) return compared.status();
    report.runs.push_back({RunLabel(other), *std::move(compared)});
  } else {
    report.note = "The radars' beta is 0, so that Doppler compensation changes nothing.";
  }
  return WriteReport(report, arguments.report_file);
}

}  // namespace

absl::Status RunEvaluation(const EvaluateArguments& arguments) {
  const absl::StatusOr<EvaluationOptions> options = ToOptions(arguments);
  if (!options.ok()) return options.status();
  if (absl::Status status = Validate(*options); !status.ok()) return status;
  absl::Status writable = CheckTrajectory(arguments.trajectory, arguments.anchor.has_value());
  if (!writable.ok()) return writable;
  const auto map_drives = ReadMapDrives(arguments);
  if (!map_drives.ok()) return map_drives.status();
  const auto drives = ReadDrives(arguments.dataset, arguments.drives, arguments.live);
  if (!drives.ok()) return drives.status();
  auto outcomes = EvaluateAll(*map_drives, *drives, *options);
  if (!outcomes.ok()) return outcomes.status();

  Print(*outcomes);
  absl::Status status = WriteText(arguments.json_file, ToJson(*outcomes).dump(2) + "\n");
  status.Update(WriteText(arguments.csv_file, ScansCsv(*outcomes)));
  status.Update(WriteTrajectories(arguments, *outcomes));
  if (!arguments.report_file.empty()) {
    status.Update(WriteReportFile(arguments, *map_drives, *drives, *options, *std::move(outcomes)));
  }
  return status;
}

}  // namespace dcloc::cli
