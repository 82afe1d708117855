#pragma once

#include <chrono>
#include <vector>

#include "client/trajectory/trajectory.h"

namespace dcloc {

/// How far a trajectory is from another at one of its stamps.
struct StampedError {
  Stamp stamp;
  double position_m = 0.0;   ///< distance in space
  double heading_deg = 0.0;  ///< of the x axis in the plane, without sign
};

/// Errors of `trajectory` against `reference`, which is interpolated between its poses; both are in
/// one frame. Stamps outside of the reference, or in a gap of it longer than `max_gap`, give none.
std::vector<StampedError> ErrorsAgainst(const Trajectory& trajectory, const Trajectory& reference,
                                        std::chrono::nanoseconds max_gap = std::chrono::seconds(1));

}  // namespace dcloc
