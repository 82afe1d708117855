#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// Adds `evaluate`: localize recorded drives in a map of another, judged by the reference poses.
void AddEvaluateCommand(CLI::App& app, int& exit_code);

}  // namespace dcloc::cli
