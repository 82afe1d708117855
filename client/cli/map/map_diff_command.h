#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// Adds `diff`, which says what two maps differ by.
void AddMapDiffCommand(CLI::App& map_command, int& exit_code);

}  // namespace dcloc::cli
