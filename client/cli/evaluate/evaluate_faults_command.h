#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// Adds `faults` to the command `evaluate`: sessions whose inputs lie. Where it is given,
/// `evaluate`'s own options are not asked for.
void AddEvaluateFaultsCommand(CLI::App& evaluate, int& exit_code);

}  // namespace dcloc::cli
