#pragma once

#include <span>

#include "client/datasets/bag_mapping.h"
#include "client/datasets/check/range_rate_check.h"

namespace dcloc {

/// The mapping with the signs of range rates and azimuths, and with whether the range rates are
/// compensated, as the targets of a drive that was read by it show them. What no sign mends stays.
BagMapping CorrectedMapping(BagMapping mapping, std::span<const RangeRateCheck> checks);

}  // namespace dcloc
