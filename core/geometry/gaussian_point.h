#pragma once

#include <Eigen/Core>

namespace dcloc {

/// A point with its uncertainty, in the plane (Dim = 2) or in space (Dim = 3), in a frame that the
/// holder names.
template <int Dim>
struct GaussianPoint {
  Eigen::Matrix<double, Dim, 1> mean_m;
  Eigen::Matrix<double, Dim, Dim> covariance_m2;
  /// Of a live point: the shift of its position per square metre of h^2, h being the height of the
  /// scatterer over a planar radar (`RadarPoint::slant_per_m`). The mean assumes h = 0.
  Eigen::Matrix<double, Dim, 1> slant_per_m = Eigen::Matrix<double, Dim, 1>::Zero();
  /// Of a landmark: the square of its height over the radars; 0 if it is not known.
  double height_square_m2 = 0.0;
};

}  // namespace dcloc
