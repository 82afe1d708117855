#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// Adds `map coverage`, which asks which maps there are of a place.
void AddMapPlaceCommands(CLI::App& map_command, int& exit_code);

}  // namespace dcloc::cli
