#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// Adds `dcloc load`. The program returns `exit_code`.
void AddLoadCommand(CLI::App& app, int& exit_code);

}  // namespace dcloc::cli
