#include "client/cli/map/server/map_call.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/common/on_run.h"
#include "client/cli/common/terminal.h"
#include "client/cli/remote/answer_text.h"
#include "client/cli/remote/server_options.h"

namespace dcloc::cli {
namespace {

using nlohmann::ordered_json;

absl::Status Run(MapCall* call, const MapArguments& arguments) {
  const auto channel = client::MakeChannel(arguments.server);
  if (!channel.ok()) return channel.status();
  client::MapClient maps(*channel);
  return NamingServer(call(maps, arguments), arguments.server);
}

ordered_json AnchorJson(const v1::GeodeticAnchor& anchor) {
  return {{"latitude_deg", anchor.origin().latitude_deg()},
          {"longitude_deg", anchor.origin().longitude_deg()},
          {"height_m", anchor.origin().height_m()},
          {"x_axis_east_rad", anchor.x_axis_east_rad()}};
}

}  // namespace

CLI::App* AddMapCall(CLI::App& map_command, const char* name, const char* description,
                     MapCall* call, const std::shared_ptr<MapArguments>& arguments,
                     int& exit_code) {
  CLI::App* app = map_command.add_subcommand(name, description);
  AddServerOptions(*app, arguments->server);
  OnRun(*app, arguments, exit_code, [call](const MapArguments& given) { return Run(call, given); });
  return app;
}

CLI::Option* AddMapName(CLI::App& command, MapArguments& arguments, const char* description) {
  return command.add_option("--map", arguments.map, description)->type_name("NAME");
}

CLI::Option* AddVersion(CLI::App& command, MapArguments& arguments) {
  return command.add_option("--version", arguments.version, "Version of the map")
      ->check(CLI::PositiveNumber)
      ->type_name("N");
}

void AddJson(CLI::App& command, MapArguments& arguments) {
  command.add_flag("--json", arguments.json, "Print as JSON");
}

ordered_json Json(const v1::Map& map) {
  return {{"name", map.name()},
          {"active_version", map.active_version()},
          {"previous_version", map.previous_version()},
          {"canary_version", map.canary_version()},
          {"canary_share", map.canary_share()},
          {"version_count", map.version_count()},
          {"create_time", TimeText(map.create_time())}};
}

ordered_json Json(const v1::MapVersion& version) {
  return {{"map", version.map_name()},
          {"version", version.version()},
          {"active", version.active()},
          {"size_bytes", version.size_bytes()},
          {"sha256", version.sha256()},
          {"create_time", TimeText(version.create_time())},
          {"drive", version.info().drive_name()},
          {"description", version.info().description()},
          {"keyframe_count", version.info().keyframe_count()},
          {"point_count", version.info().point_count()},
          {"length_m", version.info().length_m()},
          {"anchor", version.info().has_anchor() ? AnchorJson(version.info().anchor()) : nullptr}};
}

std::string Text(const v1::MapVersion& version) {
  return absl::StrFormat(
      "%s version %d%s: %d landmarks over %.0f m of street, %s", Visible(version.map_name()),
      version.version(), version.active() ? ", active" : "", version.info().point_count(),
      version.info().length_m(), FormatBytes(static_cast<double>(version.size_bytes())));
}

}  // namespace dcloc::cli
