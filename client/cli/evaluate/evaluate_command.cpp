#include "client/cli/evaluate/evaluate_command.h"

#include <memory>

#include "client/cli/common/anchor_option.h"
#include "client/cli/common/exit_codes.h"
#include "client/cli/common/terminal.h"
#include "client/cli/evaluate/evaluate_faults_command.h"
#include "client/cli/evaluate/evaluate_paper_command.h"
#include "client/cli/evaluate/evaluate_robustness_command.h"
#include "client/cli/evaluate/evaluate_run.h"

namespace dcloc::cli {
namespace {

using Arguments = EvaluateArguments;

void AddDriveOptions(CLI::App& command, Arguments& arguments) {
  AddDatasetOptions(command, arguments.dataset);
  command
      .add_option("--map-drive", arguments.map_drives,
                  "Drive to make the map of: one for all drives, or one for each")
      ->required()
      ->delimiter(',')
      ->type_name("A,B");
  command.add_option("--drive", arguments.drives, "Drives to localize, in their map's frame")
      ->required()
      ->delimiter(',')
      ->type_name("A,B");
  AddRadarsOption(command, "--map-radars", arguments.map.radars,
                  "Radars to map with; all by default");
  AddRadarsOption(command, "--radars", arguments.live.radars,
                  "Radars to localize with; all by default");
  AddDriveRequestOptions(command, arguments.live);
  command
      .add_option("--map-rig", arguments.map.rig_file,
                  "The same as --rig for the map drives alone; --rig by default")
      ->check(CLI::ExistingFile)
      ->type_name("FILE");
  command
      .add_option("--map-beta-s", arguments.map.beta_s,
                  "The same for the map drive alone; --beta-s by default")
      ->type_name("S");
}

void AddMethodOptions(CLI::App& command, Arguments& arguments) {
  Perturbation& perturbation = arguments.options.perturbation;
  std::vector<std::string> methods;
  methods.reserve(kMethodNames.size());
  for (const auto& [name, kind] : kMethodNames) methods.emplace_back(name);
  command
      .add_option("--method", arguments.method,
                  "dcloc, or one that it is compared with; those without dcloc in their name need "
                  "--initial truth")
      ->check(CLI::IsMember(methods))
      ->capture_default_str();
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
      ->check(CLI::IsMember({"doppler", "uncertainty", "truncation", "heights"}));
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
  command
      .add_option("--report", arguments.report_file,
                  "Write a page with pictures, and PNG files beside it (needs gnuplot)")
      ->type_name("FILE");
  AddTrajectoryOptions(command, arguments.trajectory);
  AddAnchorOption(command, arguments.anchor);
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
  AddEvaluateFaultsCommand(*evaluate, exit_code);
  AddEvaluatePaperCommand(*evaluate, exit_code);
  AddEvaluateRobustnessCommand(*evaluate, exit_code);
  evaluate->callback([evaluate, arguments, &exit_code] {
    if (!evaluate->get_subcommands().empty()) return;
    const absl::Status status = RunEvaluation(*arguments);
    exit_code = status.ok() ? kSuccess : Fail(status);
  });
}

}  // namespace dcloc::cli
