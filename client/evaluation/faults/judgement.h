#pragma once

#include <span>

#include "client/evaluation/faults/record.h"
#include "client/evaluation/faults/session.h"
#include "client/evaluation/faults/stream.h"

namespace dcloc::faults {

/// Answers further apart than this are no steady tracking.
inline constexpr double kMaxPause_s = 1.0;

/// The time from `end` to the first of `scans` (by ascending stamp) after it from which every
/// answer of a second is TRACKING and right, without a pause above kMaxPause_s; infinite where
/// there is none. What the localizer refused is no answer.
double SecondsUntilRight(std::span<const ScanOutcome> scans, Stamp end);

/// Judges a session in which a fault was in force during `window`. Recovery counts from the
/// window's end, if it has one within the drive.
Record JudgeFault(const SessionOutcome& outcome, const Window& window);

}  // namespace dcloc::faults
