#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "client/evaluation/faults/fault.h"

namespace dcloc::faults {

// Each changes the scans that were measured within the window. True times and poses stay true.

/// Stamps say `shift` more: of all radars, or of `radar_id` alone.
void ShiftStamps(Stream& stream, const Window& window, std::chrono::nanoseconds shift,
                 const std::optional<std::string>& radar_id = std::nullopt);

/// Scans of `radar_id` arrive `delay` later, behind others; their stamps stay right.
void DelayArrival(Stream& stream, const Window& window, const std::string& radar_id,
                  std::chrono::nanoseconds delay);

/// Every scan arrives later by a duration drawn evenly from [0, max_delay].
void JitterArrival(Stream& stream, const Window& window, std::chrono::nanoseconds max_delay,
                   std::uint64_t seed);

/// Every `interval`th scan, the first being that, arrives twice; > 0.
void DuplicateScans(Stream& stream, const Window& window, std::size_t interval);

/// Stamps are rounded to the nearest multiple of `step` since the first scan; > 0.
void RoundStamps(Stream& stream, const Window& window, std::chrono::nanoseconds step);

/// Scans between two of the rig's first radar have the stamp of the earlier of these.
void AlignStamps(Stream& stream, const Window& window);

/// Keeps scans of each radar at `rate_hz` at most.
void ThinScans(Stream& stream, const Window& window, double rate_hz);

/// Of the clock and of the transport to the localizer.
std::vector<Fault> TimeFaults();

}  // namespace dcloc::faults
