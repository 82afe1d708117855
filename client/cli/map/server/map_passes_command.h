#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// `dcloc map passes` and `dcloc map pass-consent`: what a server keeps of vehicles' drives.
void AddMapPassesCommands(CLI::App& map_command, int& exit_code);

}  // namespace dcloc::cli
