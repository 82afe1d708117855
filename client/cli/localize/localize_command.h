#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// Adds `localize`: send a recorded drive's scans to a server as a vehicle would, keep the answers.
void AddLocalizeCommand(CLI::App& app, int& exit_code);

}  // namespace dcloc::cli
