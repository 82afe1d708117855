#pragma once

#include <Eigen/Core>

namespace dcloc {

/// A point with its uncertainty, in the plane (Dim = 2) or in space (Dim = 3), in a frame that the
/// holder names.
template <int Dim>
struct GaussianPoint {
  Eigen::Matrix<double, Dim, 1> mean_m;
  Eigen::Matrix<double, Dim, Dim> covariance_m2;
};

}  // namespace dcloc
