#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// Adds `map coverage`, which lists the active maps that cover a place.
void AddMapPlaceCommands(CLI::App& map_command, int& exit_code);

}  // namespace dcloc::cli
