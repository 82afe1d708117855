#include "client/cli/map/server/map_remote_update_command.h"

#include <memory>

#include "client/cli/map/server/map_call.h"
#include "client/cli/map/server/remote_builds.h"

namespace dcloc::cli {
namespace {

absl::Status RemoteUpdate(client::MapClient& maps, const MapArguments& arguments) {
  v1::MapBuildHeader header;
  header.set_map_name(arguments.map);
  header.set_base_version(arguments.version);
  header.set_activate(arguments.activate);
  const absl::StatusOr<v1::MapBuild> started = maps.StartUpdate(header);
  if (!started.ok()) return started.status();
  return arguments.no_wait ? PrintBuild(*started, arguments.json)
                           : FollowBuild(maps, *started, arguments.json);
}

}  // namespace

void AddMapRemoteUpdateCommand(CLI::App& map_command, int& exit_code) {
  auto arguments = std::make_shared<MapArguments>();
  CLI::App* app = AddMapCall(map_command, "remote-update",
                             "Have a server bring a map up to date with the passes that it keeps",
                             &RemoteUpdate, arguments, exit_code);
  AddMapName(*app, *arguments, "The map")->required();
  AddVersion(*app, *arguments)
      ->description("Version that is brought up to date; the active one by default");
  app->add_flag("--activate", arguments->activate, "New sessions get the new version at once");
  app->add_flag("--no-wait", arguments->no_wait, "Do not wait for the build");
  AddJson(*app, *arguments);
  app->footer(
      "One pass is kept out and judges: no version is made unless it is better there. Passes are\n"
      "kept with two consents, see `dcloc map pass-consent`. Ctrl-C while it waits cancels the\n"
      "build.\n"
      "Example, first for a tenth of the vehicles:\n"
      "  dcloc map remote-update --server localhost:50051 --map town\n"
      "  dcloc map canary --server localhost:50051 --map town --version 2 --share 0.1");
}

}  // namespace dcloc::cli
