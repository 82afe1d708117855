#pragma once

#include <memory>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "core/geometry/pose.h"
#include "core/localizer/localizer.h"
#include "core/map/radar_map.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"

namespace dcloc {

/// One scan of a pass, localized in one version of a map.
struct ReplayedScan {
  bool is_tracking = false;
  Pose2 T_map_vehicle;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (x, y, yaw)
};

/// Localizes a pass in `map`, without a prior; an answer for each of `scans`, in their order. One
/// that was refused is not tracking. InvalidArgument names what is wrong with the rig.
absl::StatusOr<std::vector<ReplayedScan>> ReplayPass(std::shared_ptr<const RadarMap> map,
                                                     const Rig& rig, std::span<const Scan> scans);

/// Where odometry alone puts the vehicle at each of `scans`, from where it was at the first one. A
/// scan of a radar that `rig` does not describe, or that is late, does not move it.
std::vector<Pose2> OdometryTrack(const Rig& rig, std::span<const Scan> scans);

}  // namespace dcloc
