#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "core/calibration/calibration.h"

namespace dcloc::cli {

/// The rig with all corrections as a file that `--rig` takes (client/datasets/rig_file.h). All or
/// none: a part of them would leave errors standing that others were estimated to cancel.
nlohmann::ordered_json RigFileJson(const Calibration& calibration);

/// What was found, for scripts and for people: each correction with its 95 % interval, whether the
/// data determine it and whether 0 lies in it, and what they cannot tell apart.
nlohmann::ordered_json CalibrationJson(const Calibration& calibration);
std::string CalibrationText(const Calibration& calibration);

}  // namespace dcloc::cli
