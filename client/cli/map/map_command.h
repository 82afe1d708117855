#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// Adds `map` with its subcommands that need no server.
void AddMapCommand(CLI::App& app, int& exit_code);

}  // namespace dcloc::cli
