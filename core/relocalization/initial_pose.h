#pragma once

#include "absl/status/status.h"
#include "core/geometry/pose.h"

namespace dcloc {

/// What is known of the pose before the first scan.
struct InitialPose {
  Pose3 T_map_vehicle;
  /// In the tangent space on the right of `T_map_vehicle`.
  Matrix6d covariance;
};

/// OK, or InvalidArgument that names what is not a pose or not a covariance.
absl::Status Validate(const InitialPose& initial_pose);

}  // namespace dcloc
