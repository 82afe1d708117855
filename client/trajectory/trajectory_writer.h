#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "client/trajectory/trajectory.h"
#include "client/trajectory/trajectory_format.h"

namespace dcloc {

/// The file's text. Numbers of TUM, KITTI and CSV are exact to the last bit; degrees of GeoJSON and
/// GPX are written to a tenth of a millimetre. FailedPrecondition where the format needs an anchor
/// and the trajectory has none.
absl::StatusOr<std::string> FormatTrajectory(const Trajectory& trajectory, TrajectoryFormat format);

/// One line of TUM with its end, for those who write poses as they come.
std::string TumLine(const TrajectoryPose& entry);

}  // namespace dcloc
