#pragma once

#include <cstddef>
#include <functional>

#include "absl/status/status.h"
#include "client/datasets/drive.h"
#include "core/calibration/calibrator.h"

namespace dcloc {

/// Gives `calibrator`, which is for the drive's radars, all scans of a drive at its reference
/// poses. Drives of one `place` are taken to lie in one frame; where a drive names none, it has its
/// own. `progress` receives the number of scans done. Errors name the drive, the scan and the
/// radar.
absl::Status AddDrive(
    const Drive& drive, Calibrator& calibrator,
    const std::function<void(std::size_t)>& progress = [](std::size_t) {});

}  // namespace dcloc
