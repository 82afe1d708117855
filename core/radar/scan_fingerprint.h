#pragma once

#include <cstdint>

#include "core/radar/scan.h"

namespace dcloc {

/// A hash of all columns of a scan's targets.
std::uint64_t FingerprintOfTargets(const Scan& scan);

/// A hash of the stamp, the radar, the targets and the ticks.
std::uint64_t FingerprintOf(const Scan& scan);

}  // namespace dcloc
