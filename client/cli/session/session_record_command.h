#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// Adds `record` and `replay` to `dcloc session`. The program returns `exit_code`.
void AddSessionRecordCommands(CLI::App& session_command, int& exit_code);

}  // namespace dcloc::cli
