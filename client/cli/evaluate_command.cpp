#include "client/cli/evaluate_command.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/atomic_file.h"
#include "client/cli/dataset_options.h"
#include "client/cli/exit_codes.h"
#include "client/cli/progress.h"
#include "client/cli/terminal.h"
#include "client/datasets/drive_map.h"
#include "client/evaluation/metrics_format.h"
#include "client/evaluation/runner.h"

namespace dcloc::cli {
namespace {

struct Arguments {
  DatasetArguments dataset;
  DriveRequest map;
  DriveRequest live;  // all of it but the name
  std::vector<std::string> drives;
  std::string protocol = "track";
  std::string initial = "truth";
  std::string ego_velocity = "sensor";
  std::optional<double> query_interval_s;
  std::vector<std::string> without;
  EvaluationOptions options;
  std::string json_file;
  std::string csv_file;
};

// Percentages of progress have this many steps.
constexpr std::size_t kProgressSteps = 1000;

bool IsWithout(const Arguments& arguments, const std::string& part) {
  return std::ranges::find(arguments.without, part) != arguments.without.end();
}

EvaluationOptions ToOptions(const Arguments& arguments) {
  EvaluationOptions options = arguments.options;
  options.protocol = arguments.protocol == "pairs" ? Protocol::kPairs : Protocol::kTrack;
  options.has_initial_pose = arguments.initial == "truth";
  options.doppler_ego_velocity = arguments.ego_velocity == "doppler";
  const double customary_s = arguments.dataset.format == "nuscenes" ? 0.5 : 1.0;
  options.query_interval_s = arguments.query_interval_s.value_or(customary_s);
  options.localizer.doppler_compensation = !IsWithout(arguments, "doppler");
  options.localizer.uncertainty = !IsWithout(arguments, "uncertainty");
  options.localizer.truncation = !IsWithout(arguments, "truncation");
  return options;
}

absl::StatusOr<std::shared_ptr<const RadarMap>> MakeMap(const Arguments& arguments,
                                                        const LocalizerOptions& localizer) {
  DriveRequest request = arguments.map;
  if (!request.beta_s.has_value()) request.beta_s = arguments.live.beta_s;
  const auto drive = ReadDrive(ToDataset(arguments.dataset), request);
  if (!drive.ok()) return drive.status();
  MapBuilderOptions options;
  options.name = drive->name;
  options.static_points = localizer.static_points;
  options.static_points.compensate = localizer.doppler_compensation;
  options.static_points.uncertainty = localizer.uncertainty;
  Progress progress(absl::StrCat("mapping ", drive->name), drive->scans.size());
  auto bytes =
      BuildMap(*drive, options, [&](std::size_t scan_count) { progress.Update(scan_count); });
  if (!bytes.ok()) return bytes.status();
  return RadarMap::FromBytes(*std::move(bytes));
}

absl::StatusOr<DriveOutcome> Localize(const Arguments& arguments, const std::string& name,
                                      const std::shared_ptr<const RadarMap>& map,
                                      const EvaluationOptions& options) {
  DriveRequest request = arguments.live;
  request.name = name;
  const auto drive = ReadDrive(ToDataset(arguments.dataset), request);
  if (!drive.ok()) return drive.status();
  Progress progress(absl::StrCat("localizing ", name), kProgressSteps);
  return Evaluate(map, *drive, options, [&](double share) {
    progress.Update(static_cast<std::size_t>(share * kProgressSteps));
  });
}

nlohmann::ordered_json ToJson(const std::vector<DriveOutcome>& outcomes) {
  nlohmann::ordered_json json = MetricsJson(ComputeMetrics(outcomes));
  json["drives"] = nlohmann::ordered_json::array();
  for (const DriveOutcome& outcome : outcomes) {
    nlohmann::ordered_json drive = {{"drive", outcome.drive}};
    drive.update(MetricsJson(ComputeMetrics({&outcome, 1})));
    json["drives"].push_back(std::move(drive));
  }
  return json;
}

void Print(const std::vector<DriveOutcome>& outcomes) {
  std::vector<std::pair<std::string, Metrics>> columns;
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

absl::Status Run(const Arguments& arguments) {
  const EvaluationOptions options = ToOptions(arguments);
  if (absl::Status status = Validate(options); !status.ok()) return status;
  const auto map = MakeMap(arguments, options.localizer);
  if (!map.ok()) return map.status();
  std::vector<DriveOutcome> outcomes;
  for (const std::string& name : arguments.drives) {
    auto outcome = Localize(arguments, name, *map, options);
    if (!outcome.ok()) return outcome.status();
    outcomes.push_back(*std::move(outcome));
  }
  Print(outcomes);
  absl::Status status = WriteText(arguments.json_file, ToJson(outcomes).dump(2) + "\n");
  status.Update(WriteText(arguments.csv_file, ScansCsv(outcomes)));
  return status;
}

void AddDriveOptions(CLI::App& command, Arguments& arguments) {
  AddDatasetOptions(command, arguments.dataset);
  command.add_option("--map-drive", arguments.map.name, "Drive to make the map of")
      ->required()
      ->type_name("NAME");
  command.add_option("--drive", arguments.drives, "Drives to localize, in the map's frame")
      ->required()
      ->delimiter(',')
      ->type_name("A,B");
  AddRadarsOption(command, "--map-radars", arguments.map.radars,
                  "Radars to map with; all by default");
  AddRadarsOption(command, "--radars", arguments.live.radars,
                  "Radars to localize with; all by default");
  command
      .add_option("--beta-s", arguments.live.beta_s,
                  "Range-Doppler coupling of all radars, in place of their own")
      ->type_name("S");
  command
      .add_option("--map-beta-s", arguments.map.beta_s,
                  "The same for the map drive alone; --beta-s by default")
      ->type_name("S");
}

void AddMethodOptions(CLI::App& command, Arguments& arguments) {
  Perturbation& perturbation = arguments.options.perturbation;
  command
      .add_option("--initial", arguments.initial,
                  "First pose: the truth, perturbed, or none (the whole map is searched)")
      ->check(CLI::IsMember({"truth", "none"}))
      ->capture_default_str();
  command.add_option("--initial-error-m", perturbation.translation_m, "Perturbation, exactly")
      ->type_name("M")
      ->capture_default_str();
  command.add_option("--initial-error-deg", perturbation.rotation_deg, "Perturbation, exactly")
      ->type_name("DEG")
      ->capture_default_str();
  command.add_option("--seed", perturbation.seed, "Of the perturbation's directions")
      ->type_name("N")
      ->capture_default_str();
  command
      .add_option("--ego-velocity", arguments.ego_velocity,
                  "The vehicle's own, fused with Doppler, or Doppler alone")
      ->check(CLI::IsMember({"sensor", "doppler"}))
      ->capture_default_str();
  command
      .add_option("--without", arguments.without,
                  "Parts of the method to switch off, for map and drives alike")
      ->delimiter(',')
      ->check(CLI::IsMember({"doppler", "uncertainty", "truncation"}));
  command
      .add_option("--scans-per-submap", arguments.options.localizer.scans_per_submap,
                  "Scans of each radar in a sub-map")
      ->type_name("K")
      ->capture_default_str();
}

void AddProtocolOptions(CLI::App& command, Arguments& arguments) {
  command
      .add_option("--protocol", arguments.protocol,
                  "One session a drive (track), or separate queries of the last K scans (pairs)")
      ->check(CLI::IsMember({"track", "pairs"}))
      ->capture_default_str();
  command
      .add_option("--query-every-s", arguments.query_interval_s,
                  "Between queries of pairs; 0.5 for nuscenes and 1 for radarscenes by default")
      ->type_name("S");
  command.add_option("--json", arguments.json_file, "Write the metrics")->type_name("FILE");
  command.add_option("--csv", arguments.csv_file, "Write a line for each scan")->type_name("FILE");
}

}  // namespace

void AddEvaluateCommand(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* evaluate = app.add_subcommand(
      "evaluate", "Localize recorded drives in a map of another and judge the answers");
  AddDriveOptions(*evaluate, *arguments);
  AddMethodOptions(*evaluate, *arguments);
  AddProtocolOptions(*evaluate, *arguments);
  evaluate->footer(
      "Errors are over the scans that were answered with a pose in the map.\n"
      "Example:\n  dcloc evaluate --dataset nuscenes --root ~/nuscenes \\\n"
      "      --map-drive scene-0655 --map-radars RADAR_FRONT,RADAR_FRONT_LEFT,RADAR_FRONT_RIGHT "
      "\\\n"
      "      --drive scene-0655 --radars RADAR_BACK_LEFT,RADAR_BACK_RIGHT --json result.json");
  evaluate->callback([arguments, &exit_code] {
    const absl::Status status = Run(*arguments);
    exit_code = status.ok() ? kSuccess : Fail(status);
  });
}

}  // namespace dcloc::cli
