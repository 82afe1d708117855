#include "core/relocalization/initial_pose.h"

#include <cmath>

#include "absl/strings/str_format.h"
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
  // Beyond, sums of squares would lose what is small beside them.
  constexpr double kMaxPriorTranslation_m = 1e10;
  constexpr double kMaxVariance = 1e16;
  if (pose.translation_m.norm() > kMaxPriorTranslation_m) {
    return absl::InvalidArgumentError(
        absl::StrFormat("initial_pose.T_map_vehicle lies %g m from the map's origin; the limit is "
                        "%g m",
                        pose.translation_m.norm(), kMaxPriorTranslation_m));
  }
  if (initial_pose.covariance.diagonal().maxCoeff() > kMaxVariance) {
    return absl::InvalidArgumentError(
        absl::StrFormat("initial_pose.covariance has a variance of %g; the limit is %g",
                        initial_pose.covariance.diagonal().maxCoeff(), kMaxVariance));
  }
  return absl::OkStatus();
}

}  // namespace dcloc
