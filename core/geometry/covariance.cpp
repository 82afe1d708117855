#include "core/geometry/covariance.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>

namespace dcloc {
namespace {

constexpr std::array<int, 3> kPlanarRows = {0, 1, 5};  // x, y, yaw among the six

Matrix6d RotateBlocks(const Eigen::Matrix3d& rotation, const Matrix6d& covariance) {
  Matrix6d blocks = Matrix6d::Zero();
  blocks.topLeftCorner<3, 3>() = rotation;
  blocks.bottomRightCorner<3, 3>() = rotation;
  return blocks * covariance * blocks.transpose();
}

}  // namespace

Matrix6d FixedAxesFromTangent(const Pose3& T_parent_child, const Matrix6d& covariance_tangent) {
  return RotateBlocks(T_parent_child.Rotation(), covariance_tangent);
}

Matrix6d TangentFromFixedAxes(const Pose3& T_parent_child, const Matrix6d& covariance_fixed_axes) {
  return RotateBlocks(T_parent_child.Rotation().transpose(), covariance_fixed_axes);
}

Matrix6d EmbedCovariance(const Eigen::Matrix3d& planar, double z_variance_m2,
                         double roll_pitch_variance_rad2) {
  Matrix6d covariance = Matrix6d::Zero();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      covariance(kPlanarRows[row], kPlanarRows[column]) = planar(row, column);
    }
  }
  covariance(2, 2) = z_variance_m2;
  covariance(3, 3) = roll_pitch_variance_rad2;
  covariance(4, 4) = roll_pitch_variance_rad2;
  return covariance;
}

Eigen::Matrix3d FlattenCovariance(const Matrix6d& covariance) {
  return covariance(kPlanarRows, kPlanarRows);
}

bool IsCovariance(const Eigen::Ref<const Eigen::MatrixXd>& covariance) {
  if (covariance.rows() != covariance.cols() || !covariance.allFinite()) return false;
  const double scale = std::max(covariance.cwiseAbs().maxCoeff(), 1e-300);
  if ((covariance - covariance.transpose()).cwiseAbs().maxCoeff() > 1e-6 * scale) return false;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(covariance, Eigen::EigenvaluesOnly);
  return solver.eigenvalues().minCoeff() >= -1e-9 * scale;
}

}  // namespace dcloc
