#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "core/calibration/calibrator.h"

namespace dcloc::cli {

/// Names of what is not to be estimated: "beta", "time", "range", "yaw".
using KeptParameters = std::vector<std::string>;

/// `--keep`.
void AddKeepOption(CLI::App& app, KeptParameters& kept);

/// `options`, with the prior of what is kept as narrow as can be.
CalibratorOptions OptionsOf(const KeptParameters& kept, CalibratorOptions options = {});

}  // namespace dcloc::cli
