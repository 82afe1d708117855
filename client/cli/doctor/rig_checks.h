#pragma once

#include "client/cli/doctor/finding.h"
#include "client/datasets/drive.h"

namespace dcloc::cli {

/// Holds the description of a drive's radars against its scans: signs of range rates and azimuths,
/// mounts that are swapped, and with reference poses beta, stamps, range bias and the mounts' yaws.
/// Takes as long as `dcloc calibrate` of that drive.
Findings CheckRig(const Drive& drive);

}  // namespace dcloc::cli
