#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/calibration/static_return.h"

namespace dcloc {

/// Two returns that may be of one scatterer.
struct ReturnPair {
  std::uint32_t first;
  std::uint32_t second;
};

/// Pairs of returns nearer than `max_pair_distance_m`, of different radars or stands, at most
/// `max_per_return` for each return. The same returns give the same pairs.
std::vector<ReturnPair> FindPairs(const FrameReturns& frame, double max_pair_distance_m,
                                  std::size_t max_per_return);

}  // namespace dcloc
