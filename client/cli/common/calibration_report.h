#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "core/calibration/calibration.h"

namespace dcloc::cli {

/// The rig with all corrections as a file that `--rig` takes (client/datasets/rig_file.h). All
/// corrections or none: they were estimated together, and some cancel each other's effects.
nlohmann::ordered_json RigFileJson(std::span<const RadarCalibration> radars);

/// What was found of each radar: each correction with its 95 % interval, whether the data determine
/// it and whether 0 lies in the interval, and what of it is applied.
nlohmann::ordered_json RadarCalibrationsJson(std::span<const RadarCalibration> radars);
std::vector<std::vector<std::string>> RadarCalibrationRows(
    std::span<const RadarCalibration> radars);

/// The result as JSON and as text: the above, and the pairs that the data cannot tell apart.
nlohmann::ordered_json CalibrationJson(const Calibration& calibration);
std::string CalibrationText(const Calibration& calibration);

}  // namespace dcloc::cli
