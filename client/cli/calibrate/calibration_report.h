#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "core/calibration/calibration.h"

namespace dcloc::cli {

/// The rig with all corrections as a file that `--rig` takes (client/datasets/rig_file.h). All
/// corrections or none: they were estimated together, and some cancel each other's effects.
nlohmann::ordered_json RigFileJson(const Calibration& calibration);

/// The result as JSON and as text: each correction with its 95 % interval, whether the data
/// determine it and whether 0 lies in the interval, and the pairs that the data cannot tell apart.
nlohmann::ordered_json CalibrationJson(const Calibration& calibration);
std::string CalibrationText(const Calibration& calibration);

}  // namespace dcloc::cli
