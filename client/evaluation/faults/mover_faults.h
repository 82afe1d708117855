#pragma once

#include <cstdint>
#include <vector>

#include "client/evaluation/faults/fault.h"

namespace dcloc::faults {

/// The share of a scan's targets that vehicles take.
inline constexpr double kMoverShare = 0.6;

/// A truck ahead takes kMoverShare of the targets of each radar that looks ahead: its back and what
/// is seen below it, `gap_m` ahead of the vehicle frame's origin at the window's begin, driving
/// `relative_mps` faster than the vehicle. It comes no nearer than 6 m.
void PutTruckAhead(Stream& stream, const Window& window, double gap_m, double relative_mps,
                   std::uint64_t seed);

/// Vehicles on the lanes to both sides, as fast as ours, take kMoverShare of every radar's targets,
/// as far as it sees to there.
void PutConvoyBeside(Stream& stream, const Window& window, std::uint64_t seed);

/// Vehicles that outnumber what stands still, for 10 s.
std::vector<Fault> MoverFaults();

}  // namespace dcloc::faults
