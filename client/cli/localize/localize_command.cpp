#include "client/cli/localize/localize_command.h"

#include <memory>

#include "client/cli/common/anchor_option.h"
#include "client/cli/common/exit_codes.h"
#include "client/cli/common/terminal.h"
#include "client/cli/localize/localize_run.h"
#include "client/cli/remote/server_options.h"

namespace dcloc::cli {
namespace {

void AddDriveOptions(CLI::App& command, LocalizeArguments& arguments) {
  AddDatasetOptions(command, arguments.dataset);
  command.add_option("--drive", arguments.drive.name, "Drive to localize, in the map's frame")
      ->required()
      ->type_name("NAME");
  AddRadarsOption(command, "--radars", arguments.drive.radars,
                  "Radars to localize with; all by default");
  AddDriveRequestOptions(command, arguments.drive);
  command
      .add_option("--ego-velocity", arguments.ego_velocity,
                  "The vehicle's own, fused with Doppler, or Doppler alone")
      ->check(CLI::IsMember({"sensor", "doppler"}))
      ->capture_default_str();
}

void AddInitialPoseOptions(CLI::App& command, LocalizeArguments& arguments) {
  Perturbation& perturbation = arguments.perturbation;
  command
      .add_option("--initial", arguments.initial,
                  "First pose: the truth, perturbed; the same as a GNSS fix, which needs --anchor; "
                  "or\nnone (the whole map is searched)")
      ->check(CLI::IsMember({"truth", "gnss", "none"}))
      ->capture_default_str();
  AddAnchorOption(command, arguments.anchor);
  command.add_option("--initial-error-m", perturbation.translation_m, "Perturbation, exactly")
      ->check(CLI::Range(0.0, 1000.0))
      ->type_name("M")
      ->capture_default_str();
  command.add_option("--initial-error-deg", perturbation.rotation_deg, "Perturbation, exactly")
      ->check(CLI::Range(0.0, 180.0))
      ->type_name("DEG")
      ->capture_default_str();
  command.add_option("--seed", perturbation.seed, "Of the perturbation's directions")
      ->type_name("N")
      ->capture_default_str();
}

void AddRunOptions(CLI::App& command, LocalizeArguments& arguments) {
  command
      .add_option("--rate", arguments.rate,
                  "Send when the stamps say, or each scan when the one before it is answered")
      ->check(CLI::IsMember({"realtime", "max"}))
      ->capture_default_str();
  command
      .add_option("--scans-per-submap", arguments.scans_per_submap,
                  "Scans of each radar in a sub-map; the server's default if not given")
      ->type_name("K");
  command
      .add_option("--reconnect-s", arguments.reconnect_s,
                  "How long to try to mend a broken connection; 0 ends with it")
      ->check(CLI::Range(0.0, 86400.0))
      ->type_name("S")
      ->capture_default_str();
  command.add_option("--out", arguments.csv_file, "Write a CSV line for each answer")
      ->required()
      ->type_name("FILE");
  command
      .add_option("--fixes", arguments.fix_file,
                  "Send the position fixes of this CSV file among the scans, by their stamps")
      ->type_name("FILE");
  command
      .add_option(
          "--learned-rig", arguments.learned_rig_file,
          "Begin with what this file says was learned of the rig, if there is one, and keep "
          "in it what is learned")
      ->type_name("FILE");
  command
      .add_option("--record", arguments.record_file, "Record the session, for dcloc session replay")
      ->type_name("FILE");
  command
      .add_option("--tum", arguments.tum_file,
                  "Write the poses in the map as TUM lines: stamp x y z qx qy qz qw")
      ->type_name("FILE");
  AddTrajectoryOptions(command, arguments.trajectory);
  command.add_flag("--json", arguments.json, "Print as JSON");
}

}  // namespace

void AddLocalizeCommand(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<LocalizeArguments>();
  CLI::App* localize = app.add_subcommand(
      "localize", "Send a recorded drive to a server as its vehicle would, and keep the answers");
  AddServerOptions(*localize, arguments->server);
  localize->add_option("--map", arguments->map, "Map of the server; its active version is used")
      ->required()
      ->type_name("NAME");
  localize
      ->add_option("--vehicle", arguments->vehicle,
                   "Who the vehicle is said to be, as canaries, session list and session record "
                   "know it")
      ->type_name("NAME")
      ->capture_default_str();
  AddDriveOptions(*localize, *arguments);
  AddInitialPoseOptions(*localize, *arguments);
  AddRunOptions(*localize, *arguments);
  localize->footer(
      "CSV: stamp_ns,radar,state,x,y,z,qx,qy,qz,qw,c00..c55,latency_ms,map_version; the covariance "
      "c is of\n(x, y, z, rotation about x, y, z) in the map's fixed axes. Ctrl-C stops sending "
      "and "
      "keeps what\nis answered.\n"
      "Fixes: stamp_ns,latitude_deg,longitude_deg,height_m,horizontal_sigma_m,vertical_sigma_m\n"
      "[,heading_deg,heading_sigma_deg], which needs a map with an anchor, or in the map frame\n"
      "stamp_ns,x_m,y_m,z_m,horizontal_sigma_m,vertical_sigma_m[,yaw_deg,yaw_sigma_deg].\n"
      "Example:\n  dcloc localize --server localhost:50051 --map town --dataset nuscenes \\\n"
      "      --root ~/nuscenes --drive scene-0655 --radars RADAR_BACK_LEFT,RADAR_BACK_RIGHT \\\n"
      "      --rate max --out answers.csv");
  localize->callback([arguments, &exit_code] {
    if ((arguments->initial == "gnss") != arguments->anchor.has_value()) {
      throw CLI::RequiredError("--initial gnss and --anchor together");
    }
    const absl::Status status = RunLocalize(*arguments);
    exit_code = status.ok() ? kSuccess : Fail(status);
  });
}

}  // namespace dcloc::cli
