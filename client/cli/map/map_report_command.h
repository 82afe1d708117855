#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// Adds `report`, which says how well vehicles can know where they are in a map.
void AddMapReportCommand(CLI::App& map_command, int& exit_code);

}  // namespace dcloc::cli
