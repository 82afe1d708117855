#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// Adds `remote-update`, by which a server brings a map up to date with the passes that it keeps.
void AddMapRemoteUpdateCommand(CLI::App& map_command, int& exit_code);

}  // namespace dcloc::cli
