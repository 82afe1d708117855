#include "core/relocalization/initial_pose.h"

#include <cmath>

#include "core/geometry/covariance.h"

namespace dcloc {

absl::Status Validate(const InitialPose& initial_pose) {
  const Pose3& pose = initial_pose.T_map_vehicle;
  if (!pose.translation_m.allFinite() || !(std::abs(pose.rotation.norm() - 1.0) < 1e-3)) {
    return absl::InvalidArgumentError(
        "initial_pose.T_map_vehicle must be finite with a rotation of norm 1");
  }
  if (!IsCovariance(initial_pose.covariance)) {
    return absl::InvalidArgumentError(
        "initial_pose.covariance must be finite, symmetric and positive semidefinite");
  }
  return absl::OkStatus();
}

}  // namespace dcloc
