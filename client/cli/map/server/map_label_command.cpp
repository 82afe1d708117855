#include "client/cli/map/server/map_label_command.h"

#include <memory>

#include "absl/strings/str_format.h"
#include "client/cli/common/terminal.h"
#include "client/cli/map/server/map_call.h"

namespace dcloc::cli {
namespace {

/// Says what a map's versions are used for now.
absl::Status Print(const absl::StatusOr<v1::Map>& map, bool json) {
  if (!map.ok()) return map.status();
  if (json) {
    absl::PrintF("%s\n", Json(*map).dump(2));
    return absl::OkStatus();
  }
  absl::PrintF("%s: version %d is active", Visible(map->name()), map->active_version());
  if (map->previous_version() != 0) {
    absl::PrintF(", %d was before it", map->previous_version());
  }
  if (map->canary_version() != 0) {
    absl::PrintF(", %.4g %% of the vehicles get version %d", 100.0 * map->canary_share(),
                 map->canary_version());
  }
  absl::PrintF("\n");
  return absl::OkStatus();
}

/// The same of an answer that may have moved sessions.
template <typename Response>
absl::Status PrintMoved(const absl::StatusOr<Response>& response, const MapArguments& arguments) {
  if (!response.ok()) return response.status();
  if (arguments.json) {
    nlohmann::ordered_json json = Json(response->map());
    json["moved_session_count"] = response->moved_session_count();
    absl::PrintF("%s\n", json.dump(2));
    return absl::OkStatus();
  }
  if (arguments.move_sessions) {
    absl::PrintF("%d sessions are moved\n", response->moved_session_count());
  }
  return Print(response->map(), /*json=*/false);
}

absl::Status Activate(client::MapClient& maps, const MapArguments& arguments) {
  v1::ActivateMapVersionRequest request;
  request.set_map_name(arguments.map);
  request.set_version(arguments.version);
  request.set_move_sessions(arguments.move_sessions);
  return PrintMoved(maps.Activate(request), arguments);
}

absl::Status RollBack(client::MapClient& maps, const MapArguments& arguments) {
  v1::RollBackMapRequest request;
  request.set_map_name(arguments.map);
  request.set_move_sessions(arguments.move_sessions);
  return PrintMoved(maps.RollBack(request), arguments);
}

void AddMoveSessions(CLI::App& command, MapArguments& arguments) {
  command.add_flag("--move-sessions", arguments.move_sessions,
                   "Running sessions that did not ask for a version get it too");
}

absl::Status SetCanary(client::MapClient& maps, const MapArguments& arguments) {
  return Print(maps.SetCanary(arguments.map, arguments.version, arguments.share), arguments.json);
}

void AddActivate(CLI::App& map_command, int& exit_code) {
  auto arguments = std::make_shared<MapArguments>();
  CLI::App* app = AddMapCall(map_command, "activate", "Choose the version that new sessions get",
                             &Activate, arguments, exit_code);
  AddMapName(*app, *arguments, "The map")->required();
  AddVersion(*app, *arguments)->required();
  AddMoveSessions(*app, *arguments);
  AddJson(*app, *arguments);
  app->footer("Example:\n  dcloc map activate --server localhost:50051 --map town --version 1");
}

void AddRollBack(CLI::App& map_command, int& exit_code) {
  auto arguments = std::make_shared<MapArguments>();
  CLI::App* app =
      AddMapCall(map_command, "rollback", "Give new sessions the version that was active before",
                 &RollBack, arguments, exit_code);
  AddMapName(*app, *arguments, "The map")->required();
  AddMoveSessions(*app, *arguments);
  AddJson(*app, *arguments);
  app->footer("Example:\n  dcloc map rollback --server localhost:50051 --map town");
}

void AddCanary(CLI::App& map_command, int& exit_code) {
  auto arguments = std::make_shared<MapArguments>();
  CLI::App* app =
      AddMapCall(map_command, "canary", "Give a share of the vehicles another version to try it",
                 &SetCanary, arguments, exit_code);
  AddMapName(*app, *arguments, "The map")->required();
  CLI::Option_group* which = app->add_option_group("what", "Exactly one of them");
  CLI::Option* version = AddVersion(*which, *arguments);
  which->add_flag("--none", arguments->none, "No canary any more");
  which->require_option(1);
  CLI::Option* share =
      app->add_option("--share", arguments->share, "Share of the vehicles, above 0 and up to 1")
          ->check(CLI::Range(0.0, 1.0))
          ->type_name("X");
  version->needs(share);
  share->needs(version);
  AddJson(*app, *arguments);
  app->footer(
      "Examples:\n"
      "  dcloc map canary --server localhost:50051 --map town --version 2 --share 0.05\n"
      "  dcloc map canary --server localhost:50051 --map town --none");
}

}  // namespace

void AddMapLabelCommands(CLI::App& map_command, int& exit_code) {
  AddActivate(map_command, exit_code);
  AddRollBack(map_command, exit_code);
  AddCanary(map_command, exit_code);
}

}  // namespace dcloc::cli
