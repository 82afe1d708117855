#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// Adds to `map` what has to do with maps that a server makes: `remote-build`, `builds`,
/// `cancel-build`.
void AddMapBuildCommands(CLI::App& map_command, int& exit_code);

}  // namespace dcloc::cli
