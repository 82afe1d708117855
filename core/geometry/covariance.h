#pragma once

#include <Eigen/Core>
#include <cmath>

#include "core/geometry/pose.h"

namespace dcloc {

/// The DRMS (distance root mean square) of a position [m], of a pose in the plane or in space:
/// sqrt(sigma_x^2 + sigma_y^2), the root mean square of the horizontal error. Where both axes have
/// the deviation s, it is 1.41 s. Options that say `sigma_m` of a position bound this.
template <typename Matrix>
double HorizontalSigma(const Matrix& covariance) {
  return std::sqrt(covariance.template topLeftCorner<2, 2>().trace());
}

/// Covariance of `T_a_b * T_b_c` from those of its independent factors, all in the tangent space on
/// the right: `Ad(T_b_c^-1) S_ab Ad(T_b_c^-1)^T + S_bc`.
template <int Dim>
TangentMatrix<Dim> ComposeCovariance(const TangentMatrix<Dim>& covariance_ab,
                                     const Pose<Dim>& T_b_c,
                                     const TangentMatrix<Dim>& covariance_bc) {
  const TangentMatrix<Dim> adjoint = Adjoint(T_b_c.Inverse());
  return adjoint * covariance_ab * adjoint.transpose() + covariance_bc;
}

/// Covariance of `T^-1` from that of `T`: `Ad(T) S Ad(T)^T`.
template <int Dim>
TangentMatrix<Dim> InvertCovariance(const Pose<Dim>& T, const TangentMatrix<Dim>& covariance) {
  const TangentMatrix<Dim> adjoint = Adjoint(T);
  return adjoint * covariance * adjoint.transpose();
}

/// The wire's covariance (ROS `PoseWithCovariance`): (x, y, z, rot x, rot y, rot z) about the fixed
/// axes of the parent frame, from the tangent space on the right of `T_parent_child`.
Matrix6d FixedAxesFromTangent(const Pose3& T_parent_child, const Matrix6d& covariance_tangent);

/// The inverse of `FixedAxesFromTangent`.
Matrix6d TangentFromFixedAxes(const Pose3& T_parent_child, const Matrix6d& covariance_fixed_axes);

/// Planar covariance (x, y, yaw) placed into a 6 x 6 one; `z_variance_m2` and
/// `roll_pitch_variance_rad2` fill what a planar radar does not observe.
Matrix6d EmbedCovariance(const Eigen::Matrix3d& planar, double z_variance_m2,
                         double roll_pitch_variance_rad2);

/// Rows and columns (x, y, yaw) of a 6 x 6 covariance.
Eigen::Matrix3d FlattenCovariance(const Matrix6d& covariance);

/// True when `covariance` is finite, symmetric to rounding, and positive semidefinite to rounding.
bool IsCovariance(const Eigen::Ref<const Eigen::MatrixXd>& covariance);

}  // namespace dcloc
