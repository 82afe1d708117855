#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// Adds `align`, which ties a map to the Earth or to another map.
void AddMapAlignCommand(CLI::App& map_command, int& exit_code);

}  // namespace dcloc::cli
