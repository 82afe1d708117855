#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/evaluation/faults/stream.h"
#include "client/evaluation/outcome.h"

namespace dcloc::faults {

/// What became of a stream.
struct SessionOutcome {
  /// Answers by ascending true time, which stands as their stamp; refusals are counted.
  DriveOutcome drive;
  /// One for each of `drive.scans`, where the answer had one [m].
  std::vector<std::optional<double>> protection_level_m;
  std::size_t arrived = 0;       ///< scans that the localizer was given
  double longest_call_ms = 0.0;  ///< wall clock, of one scan
  std::string failure;           ///< an exception, or answers that are none; empty where well
};

/// Gives the stream's scans to a localizer, in the order of arrival. A scan that is refused counts
/// as such; an exception ends the session, and answers that are not finite fail it and are left
/// out. InvalidArgument for a null map, an invalid rig or prior.
absl::StatusOr<SessionOutcome> RunSession(
    const Stream& stream, const std::function<void(double)>& progress = [](double) {});

}  // namespace dcloc::faults
