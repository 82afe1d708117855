#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// Adds `dcloc session list|show|watch|end`; gives the command, for others to add to. The program
/// returns `exit_code`.
CLI::App* AddSessionCommand(CLI::App& app, int& exit_code);

}  // namespace dcloc::cli
