#pragma once

#include <span>

#include "client/evaluation/disturbance.h"
#include "client/evaluation/outcome.h"
#include "client/evaluation/robustness/tally.h"

namespace dcloc::robustness {

/// Time since the first scan after which an answer that is still INITIALIZING counts as an error;
/// before, it belongs to the start.
inline constexpr double kStartAllowance_s = 2.0;
/// Tracking is back when it is right and stays so for this long.
inline constexpr double kSteady_s = 1.0;
/// A recovery that takes longer is an incident, and misses the goal.
inline constexpr double kRecoveryGoal_s = 1.0;
/// Data within which a start should be made.
inline constexpr double kStartGoal_s = 2.0;

/// Sorts the scans of one session over a drive, in which `episodes` were disturbed, into right,
/// flagged and wrong; those of a start are not counted.
Tally CountScans(const DriveOutcome& outcome, std::span<const Episode> episodes);

/// Judges one session over a drive, in which `episodes` were disturbed. Of each episode, recovery
/// is the time from the first scan after it to the beginning of the first `kSteady_s` of right
/// tracking. Episodes before the session has tracked rightly at all belong to its start.
Tally JudgeTrack(const DriveOutcome& outcome, std::span<const Episode> episodes);

/// Judges one session that ends with its first answer called tracking, or without one. `origin` is
/// where the drive's time begins.
Tally JudgeStart(const DriveOutcome& outcome, Stamp origin);

}  // namespace dcloc::robustness
