#pragma once

#include "absl/status/status.h"
#include "core/geometry/pose.h"

namespace dcloc {

/// The pose before the first scan, with its uncertainty: the prior.
struct InitialPose {
  Pose3 T_map_vehicle;
  /// In the tangent space on the right of `T_map_vehicle`.
  Matrix6d covariance;
};

/// OK, or InvalidArgument that names what is not a pose or not a covariance.
absl::Status Validate(const InitialPose& initial_pose);

}  // namespace dcloc
