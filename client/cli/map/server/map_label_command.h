#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// Adds to `map` what says which sessions get which version: `activate`, `rollback`, `canary`.
void AddMapLabelCommands(CLI::App& map_command, int& exit_code);

}  // namespace dcloc::cli
