#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/cli/common/dataset_options.h"
#include "client/sdk/channel.h"
#include "client/sdk/map_client.h"
#include "core/geometry/geodetic_anchor.h"

/// What the subcommands of `map` that need a server have in common.
namespace dcloc::cli {

/// What they may be given; each takes its part.
struct MapArguments {
  client::ChannelOptions server;
  std::string map;
  std::int64_t version = 0;
  std::string file;
  double share = 0.0;
  bool activate = false;
  bool move_sessions = false;
  bool all_versions = false;
  bool drain = false;
  bool none = false;
  bool json = false;
  bool no_wait = false;
  std::string build;
  DatasetArguments dataset;
  DriveRequest drive;
  std::vector<std::string> drives;
  std::optional<GeodeticAnchor> anchor;
  v1::FindCoverageRequest coverage;
  v1::ReadMapTileRequest tile;
};

using MapCall = absl::Status(client::MapClient&, const MapArguments&);

/// Adds a subcommand that connects and calls; fills `arguments` when it is parsed.
CLI::App* AddMapCall(CLI::App& map_command, const char* name, const char* description,
                     MapCall* call, const std::shared_ptr<MapArguments>& arguments, int& exit_code);

CLI::Option* AddMapName(CLI::App& command, MapArguments& arguments, const char* description);
CLI::Option* AddVersion(CLI::App& command, MapArguments& arguments);
void AddJson(CLI::App& command, MapArguments& arguments);

nlohmann::ordered_json Json(const v1::Map& map);
nlohmann::ordered_json Json(const v1::MapVersion& version);

/// A line about one version.
std::string Text(const v1::MapVersion& version);

}  // namespace dcloc::cli
