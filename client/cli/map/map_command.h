#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// Adds `map` with its subcommands that need no server, `build` and `inspect`.
void AddMapCommand(CLI::App& app, int& exit_code);

}  // namespace dcloc::cli
