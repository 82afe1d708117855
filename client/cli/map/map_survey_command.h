#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// Adds `dcloc map survey`.
void AddMapSurveyCommand(CLI::App& map_command, int& exit_code);

}  // namespace dcloc::cli
