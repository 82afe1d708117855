#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "core/calibration/calibration.h"

namespace dcloc::cli {

/// The rig as a file that `--rig` takes (client/datasets/rig_file.h): of the parameters `written`,
/// those corrections that are significant.
nlohmann::ordered_json RigFileJson(const Calibration& calibration,
                                   std::span<const CalibrationParameter> written);

/// What was found, for scripts and for people: each correction with its 95 % interval, whether the
/// data determine it, whether it is written, and what they cannot tell apart.
nlohmann::ordered_json CalibrationJson(const Calibration& calibration,
                                       std::span<const CalibrationParameter> written);
std::string CalibrationText(const Calibration& calibration,
                            std::span<const CalibrationParameter> written);

}  // namespace dcloc::cli
