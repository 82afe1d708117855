#include "client/cli/map_server_command.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/time/time.h"
#include "client/cli/exit_codes.h"
#include "client/cli/progress.h"
#include "client/cli/server_options.h"
#include "client/cli/terminal.h"
#include "client/sdk/map_client.h"

namespace dcloc::cli {
namespace {

using nlohmann::ordered_json;

struct Arguments {
  client::ChannelOptions server;
  std::string map;
  std::int64_t version = 0;
  std::string file;
  bool activate = false;
  bool all_versions = false;
  bool json = false;
};

using Command = absl::Status(client::MapClient&, const Arguments&);

std::string TimeText(const google::protobuf::Timestamp& time) {
  return absl::FormatTime("%Y-%m-%dT%H:%M:%SZ", absl::FromUnixSeconds(time.seconds()),
                          absl::UTCTimeZone());
}

ordered_json Json(const v1::Map& map) {
  return {{"name", map.name()},
          {"active_version", map.active_version()},
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
          {"length_m", version.info().length_m()}};
}

template <typename Item>
void PrintJson(const std::vector<Item>& items) {
  ordered_json list = ordered_json::array();
  for (const Item& item : items) list.push_back(Json(item));
  absl::PrintF("%s\n", list.dump(2));
}

void PrintTable(const std::vector<v1::Map>& maps) {
  std::vector<std::vector<std::string>> rows = {{"map", "active", "versions", "created"}};
  for (const v1::Map& map : maps) {
    rows.push_back({map.name(),
                    map.active_version() == 0 ? "-" : absl::StrCat(map.active_version()),
                    absl::StrCat(map.version_count()), TimeText(map.create_time())});
  }
  absl::PrintF("%s", FormatTable(rows));
}

void PrintTable(const std::vector<v1::MapVersion>& versions) {
  std::vector<std::vector<std::string>> rows = {
      {"version", "active", "drive", "street [m]", "landmarks", "size", "created"}};
  for (const v1::MapVersion& version : versions) {
    rows.push_back({absl::StrCat(version.version()), version.active() ? "yes" : "",
                    version.info().drive_name(), absl::StrFormat("%.0f", version.info().length_m()),
                    absl::StrCat(version.info().point_count()),
                    FormatBytes(static_cast<double>(version.size_bytes())),
                    TimeText(version.create_time())});
  }
  absl::PrintF("%s", FormatTable(rows));
}

template <typename Item>
absl::Status Print(const absl::StatusOr<std::vector<Item>>& items, bool json) {
  if (!items.ok()) return items.status();
  json ? PrintJson(*items) : PrintTable(*items);
  return absl::OkStatus();
}

absl::Status Upload(client::MapClient& maps, const Arguments& arguments) {
  std::error_code no_size;  // Upload says what is wrong with the file
  Progress progress(absl::StrCat("uploading ", arguments.file),
                    std::filesystem::file_size(arguments.file, no_size));
  const auto version = maps.Upload(arguments.file, arguments.map, arguments.activate,
                                   [&](std::int64_t sent_bytes, std::int64_t /*size_bytes*/) {
                                     progress.Update(static_cast<std::size_t>(sent_bytes));
                                   });
  if (!version.ok()) return version.status();
  if (arguments.json) {
    absl::PrintF("%s\n", Json(*version).dump(2));
  } else {
    absl::PrintF("%s version %d%s: %d landmarks over %.0f m of street, %s\n", version->map_name(),
                 version->version(), version->active() ? ", active" : "",
                 version->info().point_count(), version->info().length_m(),
                 FormatBytes(static_cast<double>(version->size_bytes())));
  }
  return absl::OkStatus();
}

absl::Status List(client::MapClient& maps, const Arguments& arguments) {
  return arguments.map.empty() ? Print(maps.List(), arguments.json)
                               : Print(maps.ListVersions(arguments.map), arguments.json);
}

absl::Status Activate(client::MapClient& maps, const Arguments& arguments) {
  const auto map = maps.Activate(arguments.map, arguments.version);
  if (!map.ok()) return map.status();
  absl::PrintF("%s\n", arguments.json ? Json(*map).dump(2)
                                      : absl::StrFormat("%s: version %d is active", map->name(),
                                                        map->active_version()));
  return absl::OkStatus();
}

absl::Status Delete(client::MapClient& maps, const Arguments& arguments) {
  return arguments.all_versions ? maps.Delete(arguments.map)
                                : maps.DeleteVersion(arguments.map, arguments.version);
}

absl::Status Run(Command* command, const Arguments& arguments) {
  const auto channel = client::MakeChannel(arguments.server);
  if (!channel.ok()) return channel.status();
  client::MapClient maps(*channel);
  const absl::Status status = command(maps, arguments);
  // An error of the connection need not say with whom.
  if (!absl::IsUnavailable(status) && !absl::IsDeadlineExceeded(status)) return status;
  return absl::Status(status.code(), absl::StrCat(arguments.server.server, ": ", status.message()));
}

CLI::App* AddCommand(CLI::App& map_command, const char* name, const char* description,
                     Command* command, const std::shared_ptr<Arguments>& arguments,
                     int& exit_code) {
  CLI::App* app = map_command.add_subcommand(name, description);
  AddServerOptions(*app, arguments->server);
  app->callback([command, arguments, &exit_code] {
    const absl::Status status = Run(command, *arguments);
    exit_code = status.ok() ? kSuccess : Fail(status);
  });
  return app;
}

CLI::Option* AddMapName(CLI::App& command, Arguments& arguments, const char* description) {
  return command.add_option("--map", arguments.map, description)->type_name("NAME");
}

CLI::Option* AddVersion(CLI::App& command, Arguments& arguments) {
  return command.add_option("--version", arguments.version, "Version of the map")
      ->check(CLI::PositiveNumber)
      ->type_name("N");
}

void AddJson(CLI::App& command, Arguments& arguments) {
  command.add_flag("--json", arguments.json, "Print as JSON");
}

}  // namespace

void AddMapServerCommands(CLI::App& map_command, int& exit_code) {
  auto upload = std::make_shared<Arguments>();
  CLI::App* app = AddCommand(map_command, "upload", "Give a server a map file as a new version",
                             &Upload, upload, exit_code);
  AddMapName(*app, *upload, "Map that gets the version; made if it is new")->required();
  app->add_flag("--activate", upload->activate, "New sessions get this version at once");
  app->add_option("file", upload->file, "Map file")->required()->type_name("FILE");
  AddJson(*app, *upload);
  app->footer(
      "Example:\n"
      "  dcloc map upload --server localhost:50051 --map town --activate scene-0655.dclm");

  auto list = std::make_shared<Arguments>();
  app = AddCommand(map_command, "list", "List a server's maps, or the versions of one", &List, list,
                   exit_code);
  AddMapName(*app, *list, "Map whose versions are listed");
  AddJson(*app, *list);
  app->footer("Example:\n  dcloc map list --server localhost:50051 --map town");

  auto activate = std::make_shared<Arguments>();
  app = AddCommand(map_command, "activate", "Choose the version that new sessions get", &Activate,
                   activate, exit_code);
  AddMapName(*app, *activate, "The map")->required();
  AddVersion(*app, *activate)->required();
  AddJson(*app, *activate);
  app->footer("Example:\n  dcloc map activate --server localhost:50051 --map town --version 1");

  auto deletion = std::make_shared<Arguments>();
  app = AddCommand(map_command, "delete", "Delete a version of a map, or all of it", &Delete,
                   deletion, exit_code);
  AddMapName(*app, *deletion, "The map")->required();
  CLI::Option_group* which = app->add_option_group("what", "Exactly one of them");
  AddVersion(*which, *deletion);
  which->add_flag("--all-versions", deletion->all_versions, "The map with all of its versions");
  which->require_option(1);
  app->footer("Example:\n  dcloc map delete --server localhost:50051 --map town --version 1");
}

}  // namespace dcloc::cli
