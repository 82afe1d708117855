#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// Adds `simulate`: drives through a made-up world with exact truth, in the nuScenes layout.
void AddSimulateCommand(CLI::App& app, int& exit_code);

}  // namespace dcloc::cli
