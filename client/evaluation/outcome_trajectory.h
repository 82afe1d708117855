#pragma once

#include <optional>

#include "client/evaluation/outcome.h"
#include "client/trajectory/trajectory.h"

namespace dcloc {

/// The answers of a drive that are poses in the map.
Trajectory TrajectoryOf(const DriveOutcome& outcome, const std::optional<GeodeticAnchor>& anchor);

}  // namespace dcloc
