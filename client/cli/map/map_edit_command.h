#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// Adds `crop`, `remove`, `split` and `merge`, which make maps of maps.
void AddMapEditCommands(CLI::App& map_command, int& exit_code);

}  // namespace dcloc::cli
