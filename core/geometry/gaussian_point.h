#pragma once

#include <Eigen/Core>

namespace dcloc {

/// A point with its uncertainty, in the plane (Dim = 2) or in space (Dim = 3), in a frame that the
/// holder names.
template <int Dim>
struct GaussianPoint {
  Eigen::Matrix<double, Dim, 1> mean_m;
  Eigen::Matrix<double, Dim, Dim> covariance_m2;
  /// Of a live point: what a scatterer above or below a planar radar moves it by for each square
  /// metre of that height's square (`RadarPoint::slant_per_m`); the mean is as if it were 0.
  Eigen::Matrix<double, Dim, 1> slant_per_m = Eigen::Matrix<double, Dim, 1>::Zero();
  /// Of a landmark: the square of its height over the radars, as far as it is known.
  double height_square_m2 = 0.0;
};

}  // namespace dcloc
