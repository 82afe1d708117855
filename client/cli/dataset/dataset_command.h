#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// Adds `dataset inspect`, `dataset trajectory` and `dataset export`: what recorded drives hold.
void AddDatasetCommand(CLI::App& app, int& exit_code);

}  // namespace dcloc::cli
