#include "client/cli/map/server/map_server_command.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/common/progress.h"
#include "client/cli/common/terminal.h"
#include "client/cli/map/server/map_build_command.h"
#include "client/cli/map/server/map_call.h"
#include "client/cli/map/server/map_label_command.h"
#include "client/cli/map/server/map_passes_command.h"
#include "client/cli/map/server/map_place_command.h"
#include "client/cli/remote/answer_text.h"

namespace dcloc::cli {
namespace {

using nlohmann::ordered_json;

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

absl::Status Print(const absl::StatusOr<v1::MapVersion>& version, bool json) {
  if (!version.ok()) return version.status();
  absl::PrintF("%s\n", json ? Json(*version).dump(2) : Text(*version));
  return absl::OkStatus();
}

absl::Status Upload(client::MapClient& maps, const MapArguments& arguments) {
  std::error_code no_size;  // Upload says what is wrong with the file
  Progress progress(absl::StrCat("uploading ", arguments.file),
                    std::filesystem::file_size(arguments.file, no_size));
  const auto version =
      maps.Upload(arguments.file, arguments.map,
                  {.activate = arguments.activate,
                   .progress = [&](std::int64_t sent_bytes, std::int64_t /*size_bytes*/) {
                     progress.Update(static_cast<std::size_t>(sent_bytes));
                   }});
  return Print(version, arguments.json);
}

absl::Status List(client::MapClient& maps, const MapArguments& arguments) {
  return arguments.map.empty() ? Print(maps.List(), arguments.json)
                               : Print(maps.ListVersions(arguments.map), arguments.json);
}

absl::Status Download(client::MapClient& maps, const MapArguments& arguments) {
  std::optional<Progress> progress;
  const auto version =
      maps.Download(arguments.map, arguments.version, arguments.file,
                    [&](std::int64_t done_bytes, std::int64_t size_bytes) {
                      if (!progress) {
                        progress.emplace(absl::StrCat("downloading ", arguments.file),
                                         static_cast<std::size_t>(size_bytes));
                      }
                      progress->Update(static_cast<std::size_t>(done_bytes));
                    });
  progress.reset();
  return Print(version, arguments.json);
}

absl::Status Delete(client::MapClient& maps, const MapArguments& arguments) {
  absl::Status status = arguments.all_versions
                            ? maps.Delete(arguments.map, arguments.drain)
                            : maps.DeleteVersion(arguments.map, arguments.version, arguments.drain);
  if (!status.ok() || !arguments.json) return status;
  ordered_json deleted = {{"map", arguments.map}};
  if (!arguments.all_versions) deleted["version"] = arguments.version;
  absl::PrintF("%s\n", deleted.dump(2));
  return status;
}

void AddUpload(CLI::App& map_command, int& exit_code) {
  auto arguments = std::make_shared<MapArguments>();
  CLI::App* app = AddMapCall(map_command, "upload", "Give a server a map file as a new version",
                             &Upload, arguments, exit_code);
  AddMapName(*app, *arguments, "Map that gets the version; made if it is new")->required();
  app->add_flag("--activate", arguments->activate, "New sessions get this version at once");
  app->add_option("file", arguments->file, "Map file")->required()->type_name("FILE");
  AddJson(*app, *arguments);
  app->footer(
      "An upload whose connection breaks goes on by itself where the server has it; one that was\n"
      "interrupted does so when the command is given again.\n"
      "Example:\n"
      "  dcloc map upload --server localhost:50051 --map town --activate scene-0655.dclm");
}

void AddDownload(CLI::App& map_command, int& exit_code) {
  auto arguments = std::make_shared<MapArguments>();
  CLI::App* app = AddMapCall(map_command, "download", "Fetch a version's map file", &Download,
                             arguments, exit_code);
  AddMapName(*app, *arguments, "The map")->required();
  AddVersion(*app, *arguments)->description("Version of the map; the active one by default");
  app->add_option("--out", arguments->file, "File to write")->required()->type_name("FILE");
  AddJson(*app, *arguments);
  app->footer("Example:\n  dcloc map download --server localhost:50051 --map town --out town.dclm");
}

void AddList(CLI::App& map_command, int& exit_code) {
  auto arguments = std::make_shared<MapArguments>();
  CLI::App* app = AddMapCall(map_command, "list", "List a server's maps, or the versions of one",
                             &List, arguments, exit_code);
  AddMapName(*app, *arguments, "Map whose versions are listed");
  AddJson(*app, *arguments);
  app->footer("Example:\n  dcloc map list --server localhost:50051 --map town");
}

void AddDelete(CLI::App& map_command, int& exit_code) {
  auto arguments = std::make_shared<MapArguments>();
  CLI::App* app = AddMapCall(map_command, "delete", "Delete a version of a map, or all of it",
                             &Delete, arguments, exit_code);
  AddMapName(*app, *arguments, "The map")->required();
  CLI::Option_group* which = app->add_option_group("what", "Exactly one of them");
  AddVersion(*which, *arguments);
  which->add_flag("--all-versions", arguments->all_versions, "The map with all of its versions");
  which->require_option(1);
  app->add_flag("--drain", arguments->drain,
                "Sessions in it move to the version that they would get now, or are ended");
  AddJson(*app, *arguments);
  app->footer(
      "Without --drain a version that is in use is kept, and that is an error.\n"
      "Example:\n"
      "  dcloc map delete --server localhost:50051 --map town --version 1 --drain");
}

}  // namespace

void AddMapServerCommands(CLI::App& map_command, int& exit_code) {
  AddUpload(map_command, exit_code);
  AddDownload(map_command, exit_code);
  AddList(map_command, exit_code);
  AddDelete(map_command, exit_code);
  AddMapBuildCommands(map_command, exit_code);
  AddMapPassesCommands(map_command, exit_code);
  AddMapLabelCommands(map_command, exit_code);
  AddMapPlaceCommands(map_command, exit_code);
}

}  // namespace dcloc::cli
