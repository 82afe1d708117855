#pragma once

#include <chrono>
#include <optional>
#include <span>

#include "core/geometry/pose.h"
#include "core/radar/scan.h"

namespace dcloc {

/// What ticks tell of the motion in the time `age` before a scan, beside the velocities at both its
/// ends: the motion that `Integrate` makes of those, times this, is the motion that went as the
/// ticks say. A constant error of the ticks is no part of it, since only how they bend counts
/// (METHOD section 2).
///
/// `ticks` are valid ones of the scan (`Validate`). The last one holds for 0.05 s. Nothing where
/// they do not reach over the whole time, or are more than 0.25 s apart.
std::optional<Pose3> BeyondTheLine(std::span<const MotionTick> ticks, std::chrono::nanoseconds age);

}  // namespace dcloc
