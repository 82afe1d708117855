#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// Adds `doctor`: what is wrong between a vehicle, its data and a server, and what to do.
void AddDoctorCommand(CLI::App& app, int& exit_code);

}  // namespace dcloc::cli
