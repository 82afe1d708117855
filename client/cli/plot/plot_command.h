#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// Adds `plot`: draw trajectories, and how far they are from another one.
void AddPlotCommand(CLI::App& app, int& exit_code);

}  // namespace dcloc::cli
