#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// Adds `export` and `import`: landmarks and keyframes as files of other tools, and back.
void AddMapExchangeCommands(CLI::App& map_command, int& exit_code);

}  // namespace dcloc::cli
