#pragma once

#include <bitset>

#include "core/geometry/pose.h"

namespace dcloc {

/// The error of a pose estimate, and whether its covariance is consistent with it.
struct PoseError {
  /// `truth = estimate Exp(tangent)`: (x, y, z [m], roll, pitch, yaw [rad]) in the estimate's
  /// frame.
  Vector6d tangent = Vector6d::Zero();
  double translation_m = 0.0;  ///< norm, in space
  double rotation_deg = 0.0;   ///< angle of the whole rotation
  int dof = 0;                 ///< observed degrees of freedom, what `nees` is over
  double nees = 0.0;           ///< squared Mahalanobis distance; infinite for a singular covariance
};

/// `covariance` is in the tangent space on the right of `T_map_vehicle`; only the `observed`
/// degrees of freedom count in the NEES.
PoseError ComparePoses(const Pose3& T_map_vehicle, const Matrix6d& covariance,
                       const std::bitset<6>& observed, const Pose3& T_map_vehicle_true);

/// Quantiles of the chi-square distribution; `dof` in [1, 6].
double ChiSquare95(int dof);
double ChiSquare999(int dof);

}  // namespace dcloc
