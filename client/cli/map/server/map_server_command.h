#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// Adds the subcommands of `map` that manage a server's maps: `upload`, `download`, `list`,
/// `delete`, and those of `AddMapBuildCommands`, `AddMapLabelCommands` and `AddMapPlaceCommands`.
void AddMapServerCommands(CLI::App& map_command, int& exit_code);

}  // namespace dcloc::cli
