#pragma once

#include <vector>

#include "client/evaluation/faults/fault.h"

namespace dcloc::faults {

/// The vehicle is carried `distance_m` along its path: what it would have measured meanwhile is
/// missing, and the clock has not gone on. `measured`, `arrived` and the stamps of what follows
/// close up, so that the stream has no gap; velocities are the true ones on either side.
void CarryAhead(Stream& stream, Stamp begin, double distance_m);

/// The prior lies off the truth by a pose in the vehicle's frame (x ahead, y to the left), and
/// claims to be within 0.5 m and 1 degree (one deviation). The stream has scans.
void MisplacePrior(Stream& stream, const Pose2& T_truth_prior);

/// The vehicle is elsewhere than all says.
std::vector<Fault> PlaceFaults();

}  // namespace dcloc::faults
