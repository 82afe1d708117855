#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// Adds `propose` to `dcloc session`. The program returns `exit_code`.
void AddSessionProposeCommand(CLI::App& session_command, int& exit_code);

}  // namespace dcloc::cli
