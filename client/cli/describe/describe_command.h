#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace dcloc::cli {

/// Adds `dcloc completion` and `dcloc manual`, which describe all that has been or will be added to
/// `app`, a program of that version. The program returns `exit_code`.
void AddDescribeCommands(CLI::App& app, const std::string& version, int& exit_code);

}  // namespace dcloc::cli
