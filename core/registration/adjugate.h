#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace dcloc {

/// The adjugate of a symmetric matrix: its inverse times its determinant.
template <typename Scalar>
Eigen::Matrix<Scalar, 2, 2> Adjugate(const Eigen::Matrix<Scalar, 2, 2>& m) {
  Eigen::Matrix<Scalar, 2, 2> adjugate;
  adjugate << m(1, 1), -m(0, 1), -m(1, 0), m(0, 0);
  return adjugate;
}

template <typename Scalar>
Eigen::Matrix<Scalar, 3, 3> Adjugate(const Eigen::Matrix<Scalar, 3, 3>& m) {
  Eigen::Matrix<Scalar, 3, 3> adjugate;
  adjugate.row(0) = m.col(1).cross(m.col(2)).transpose();
  adjugate.row(1) = m.col(2).cross(m.col(0)).transpose();
  adjugate.row(2) = m.col(0).cross(m.col(1)).transpose();
  return adjugate;
}

}  // namespace dcloc
