#pragma once

#include <cstdint>
#include <vector>

#include "client/evaluation/faults/fault.h"

namespace dcloc::faults {

/// Along the street that is driven within the window, `share` of the landmarks are those of another
/// street of the same kind: of half a map on, seen in a mirror, so that they lie nowhere else in
/// the map. The stream has a map.
void ReplaceLandmarks(Stream& stream, const Window& window, double share, std::uint64_t seed);

/// The map has no street that is driven within the window. The stream has a map.
void RemoveStreet(Stream& stream, const Window& window);

/// Of a map that is not, or no longer, of the place.
std::vector<Fault> MapFaults();

}  // namespace dcloc::faults
