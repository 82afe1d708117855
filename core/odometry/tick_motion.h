#pragma once

#include <optional>
#include <span>

#include "core/geometry/pose.h"
#include "core/radar/scan.h"

namespace dcloc {

/// What ticks between two moments tell beside the velocities at them: the motion that `Integrate`
/// makes of those, times this, is the motion that went as the ticks say. A constant error of the
/// ticks is no part of it, since only how they bend counts.
///
/// `ticks` are by ascending stamp. The last one holds for 0.05 s. Nothing where they do not reach
/// from `begin` to `end`, or are more than 0.25 s apart.
std::optional<Pose3> BeyondTheLine(std::span<const MotionTick> ticks, Stamp begin, Stamp end);

}  // namespace dcloc
