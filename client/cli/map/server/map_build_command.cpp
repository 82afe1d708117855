#include "client/cli/map/server/map_build_command.h"

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/common/anchor_option.h"
#include "client/cli/common/dataset_options.h"
#include "client/cli/common/progress.h"
#include "client/cli/common/terminal.h"
#include "client/cli/map/server/map_call.h"
#include "client/cli/map/server/map_remote_survey_command.h"
#include "client/cli/map/server/map_remote_update_command.h"
#include "client/cli/map/server/remote_builds.h"
#include "client/cli/remote/answer_text.h"
#include "client/cli/remote/wire.h"

namespace dcloc::cli {
namespace {

using nlohmann::ordered_json;

absl::StatusOr<v1::MapBuild> SendScans(client::MapClient& maps, const MapArguments& arguments,
                                       const Drive& drive) {
  v1::MapBuildHeader header;
  header.set_map_name(arguments.map);
  *header.mutable_rig() = ToProto(drive.rig);
  header.set_drive_name(drive.name);
  header.set_description(absl::StrCat("dcloc map remote-build: ", arguments.dataset.format));
  header.set_activate(arguments.activate);
  if (arguments.anchor) *header.mutable_anchor() = ToProto(*arguments.anchor);
  Progress progress("sending scans", drive.scans.size());
  std::size_t sent = 0;
  return maps.StartBuild(header, [&](v1::PosedScan* message) {
    if (sent == drive.scans.size()) return false;
    const auto& [scan, T_map_vehicle] = drive.scans[sent];
    *message->mutable_scan() = ToProto(scan, static_cast<std::int64_t>(sent));
    *message->mutable_t_map_vehicle() =
        ToProto(InitialPose{T_map_vehicle, Matrix6d::Zero()}).pose();
    progress.Update(++sent);
    return true;
  });
}

absl::Status RemoteBuild(client::MapClient& maps, const MapArguments& arguments) {
  const auto drive = ReadDrive(arguments.dataset, arguments.drive);
  if (!drive.ok()) return drive.status();
  const absl::StatusOr<v1::MapBuild> started = SendScans(maps, arguments, *drive);
  if (!started.ok()) return started.status();
  return arguments.no_wait ? PrintBuild(*started, arguments.json)
                           : FollowBuild(maps, *started, arguments.json);
}

absl::Status ListBuilds(client::MapClient& maps, const MapArguments& arguments) {
  const auto builds = maps.ListBuilds();
  if (!builds.ok()) return builds.status();
  ordered_json list = ordered_json::array();
  std::vector<std::vector<std::string>> rows = {{"build", "map", "state", "scans", "started"}};
  for (const v1::MapBuild& build : *builds) {
    list.push_back(BuildJson(build));
    rows.push_back({build.build_id(), build.map_name(), StateText(build),
                    absl::StrFormat("%d/%d", build.done_scan_count(), build.scan_count()),
                    TimeText(build.create_time())});
  }
  absl::PrintF("%s", arguments.json ? list.dump(2) + "\n" : FormatTable(rows));
  return absl::OkStatus();
}

absl::Status CancelBuild(client::MapClient& maps, const MapArguments& arguments) {
  const auto build = maps.CancelBuild(arguments.build);
  return build.ok() ? PrintBuild(*build, arguments.json) : build.status();
}

void AddRemoteBuild(CLI::App& map_command, int& exit_code) {
  auto arguments = std::make_shared<MapArguments>();
  CLI::App* app =
      AddMapCall(map_command, "remote-build", "Have a server make a version of a recorded drive",
                 &RemoteBuild, arguments, exit_code);
  AddDatasetOptions(*app, arguments->dataset);
  app->add_option("--drive", arguments->drive.name, "Drive to map: scene or sequence")
      ->required()
      ->type_name("NAME");
  AddRadarsOption(*app, "--radars", arguments->drive.radars, "Radars to map with; all by default");
  AddDriveRequestOptions(*app, arguments->drive);
  AddAnchorOption(*app, arguments->anchor);
  AddMapName(*app, *arguments, "Map that gets the version; made if it is new")->required();
  app->add_flag("--activate", arguments->activate, "New sessions get this version once it is made");
  app->add_flag("--no-wait", arguments->no_wait,
                "Do not wait for the build once the scans are there");
  AddJson(*app, *arguments);
  app->footer(
      "Example:\n"
      "  dcloc map remote-build --server localhost:50051 --map town --activate \\\n"
      "      --dataset nuscenes --root ~/nuscenes --drive scene-0655");
}

void AddBuilds(CLI::App& map_command, int& exit_code) {
  auto arguments = std::make_shared<MapArguments>();
  CLI::App* app = AddMapCall(map_command, "builds", "List the maps that a server makes or has made",
                             &ListBuilds, arguments, exit_code);
  AddJson(*app, *arguments);
  app->footer("Example:\n  dcloc map builds --server localhost:50051");
}

void AddCancelBuild(CLI::App& map_command, int& exit_code) {
  auto arguments = std::make_shared<MapArguments>();
  CLI::App* app = AddMapCall(map_command, "cancel-build", "End a build that is under way",
                             &CancelBuild, arguments, exit_code);
  app->add_option("--build", arguments->build, "The build")->required()->type_name("ID");
  AddJson(*app, *arguments);
  app->footer(
      "Example:\n  dcloc map cancel-build --server localhost:50051 --build 0123456789abcdef");
}

}  // namespace

void AddMapBuildCommands(CLI::App& map_command, int& exit_code) {
  AddRemoteBuild(map_command, exit_code);
  AddBuilds(map_command, exit_code);
  AddMapRemoteSurveyCommand(map_command, exit_code);
  AddMapRemoteUpdateCommand(map_command, exit_code);
  AddCancelBuild(map_command, exit_code);
}

}  // namespace dcloc::cli
