#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// Adds `dcloc map update` to `map_command`.
void AddMapUpdateCommand(CLI::App& map_command, int& exit_code);

}  // namespace dcloc::cli
