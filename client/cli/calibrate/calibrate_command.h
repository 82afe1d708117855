#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// Adds `calibrate`.
void AddCalibrateCommand(CLI::App& app, int& exit_code);

}  // namespace dcloc::cli
