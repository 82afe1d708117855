#pragma once

#include <span>

#include "client/datasets/bag_mapping.h"
#include "client/datasets/check/range_rate_check.h"

namespace dcloc {

/// The mapping with the signs of range rates and azimuths, and with whether the range rates are
/// compensated, as the targets of a drive that was read by it show them. What no sign mends stays.
BagMapping CorrectedMapping(BagMapping mapping, std::span<const RangeRateCheck> checks);

/// The mapping with a vehicle frame that is level, where velocities are of Doppler and the way
/// leads out of the frame's xy plane by `tilt_rad` (TiltOfWay): turned about y, with all that sits
/// on it. As it is where it does not state what sits on it; then TF does, which no mapping changes.
BagMapping LevelMapping(BagMapping mapping, double tilt_rad);

}  // namespace dcloc
