#include "client/evaluation/outcome_trajectory.h"

namespace dcloc {

Trajectory TrajectoryOf(const DriveOutcome& outcome, const std::optional<GeodeticAnchor>& anchor) {
  Trajectory trajectory{.name = outcome.drive, .anchor = anchor, .poses = {}};
  trajectory.poses.reserve(outcome.scans.size());
  for (const ScanOutcome& scan : outcome.scans) {
    if (!scan.answered()) continue;
    trajectory.poses.push_back({scan.answer.stamp, scan.answer.T_map_vehicle});
  }
  SortByStamp(trajectory.poses);
  return trajectory;
}

}  // namespace dcloc
