#pragma once

#include <CLI/CLI.hpp>

namespace dcloc::cli {

/// Adds `paper` to the command `evaluate`: the paper's evaluation, repeated. Where it is given,
/// `evaluate`'s own options are not asked for.
void AddEvaluatePaperCommand(CLI::App& evaluate, int& exit_code);

}  // namespace dcloc::cli
