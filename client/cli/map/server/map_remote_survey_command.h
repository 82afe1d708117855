#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// `dcloc map remote-survey`: a server makes a map of drives whose poses are not known.
void AddMapRemoteSurveyCommand(CLI::App& map_command, int& exit_code);

}  // namespace dcloc::cli
