#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// Adds `robustness` to the command `evaluate`: disturbed drives, tunnels and starts. Where it is
/// given, `evaluate`'s own options are not asked for.
void AddEvaluateRobustnessCommand(CLI::App& evaluate, int& exit_code);

}  // namespace dcloc::cli
