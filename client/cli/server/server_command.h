#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// Adds `dcloc server status|drain`. The program returns `exit_code`.
void AddServerCommand(CLI::App& app, int& exit_code);

}  // namespace dcloc::cli
