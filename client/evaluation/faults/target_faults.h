#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/evaluation/faults/fault.h"

namespace dcloc::faults {

// Each changes the scans that were measured within the window: of `radar_id`, or of every radar
// where it is absent.

/// Targets stay those of the last scan before, under new stamps and with new velocities.
void FreezeTargets(Stream& stream, const Window& window,
                   const std::optional<std::string>& radar_id);

/// Range rates are 0.
void ZeroRangeRates(Stream& stream, const Window& window,
                    const std::optional<std::string>& radar_id);

/// The reported ego-motion is taken out of the range rates of all radars: static targets have 0.
void CompensateRangeRates(Stream& stream, const Window& window);

/// `share` of the targets are elsewhere in the radar's view, and move at random.
void ReplaceByGhosts(Stream& stream, const Window& window,
                     const std::optional<std::string>& radar_id, double share, std::uint64_t seed);

/// Ranges are `bias_m` longer than they are.
void BiasRange(Stream& stream, const Window& window, const std::optional<std::string>& radar_id,
               double bias_m);

/// Each radar sees as many targets again, within 15 m, that move along with the vehicle: a bumper,
/// a trailer, rain on the cover.
void AddOwnBody(Stream& stream, const Window& window, std::uint64_t seed);

/// Only targets within `reach_m` are seen, as through mud.
void BlockView(Stream& stream, const Window& window, const std::optional<std::string>& radar_id,
               double reach_m);

/// Of what radars see; "one radar" is the first of the rig.
std::vector<Fault> TargetFaults();

}  // namespace dcloc::faults
