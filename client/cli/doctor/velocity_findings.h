#pragma once

#include "client/cli/doctor/finding.h"
#include "client/datasets/check/velocity_check.h"

namespace dcloc::cli {

/// What a check of the vehicle's velocities comes to: scans without one, units, signs and a delay.
Findings VelocityFindings(const VelocityCheck& check);

}  // namespace dcloc::cli
