#pragma once

#include <Eigen/Core>

#include "core/geometry/gaussian_point.h"

namespace dcloc {

/// A GaussianPoint of a local map, in its frame, packed into single precision. At each scan a
/// tracker reads the landmarks around its vehicle. By then other vehicles' landmarks have evicted
/// them from the processor's caches, so reading their bytes costs as much as the arithmetic.
/// Positions within 100 m of the frame's origin are exact to 4 micrometres.
template <int Dim>
struct PackedPoint {
  Eigen::Matrix<float, Dim, 1> mean_m = Eigen::Matrix<float, Dim, 1>::Zero();
  float height_square_m2 = 0.0F;
  /// The covariance's lower triangle, row by row.
  Eigen::Matrix<float, Dim*(Dim + 1) / 2, 1> triangle_m2 =
      Eigen::Matrix<float, Dim*(Dim + 1) / 2, 1>::Zero();

  PackedPoint() = default;

  explicit PackedPoint(const GaussianPoint<Dim>& point)
      : mean_m(point.mean_m.template cast<float>()),
        height_square_m2(static_cast<float>(point.height_square_m2)) {
    for (int row = 0, next = 0; row < Dim; ++row) {
      for (int column = 0; column <= row; ++column) {
        triangle_m2(next++) = static_cast<float>(point.covariance_m2(row, column));
      }
    }
  }

  /// Where a live point with this `GaussianPoint::slant_per_m` sees the landmark.
  template <typename Scalar>
  Eigen::Matrix<Scalar, Dim, 1> SeenBy(const Eigen::Matrix<Scalar, Dim, 1>& slant_per_m) const {
    return mean_m.template cast<Scalar>() + Scalar{height_square_m2} * slant_per_m;
  }

  template <typename Scalar = double>
  Eigen::Matrix<Scalar, Dim, Dim> Covariance_m2() const {
    Eigen::Matrix<Scalar, Dim, Dim> covariance_m2;
    for (int row = 0, next = 0; row < Dim; ++row) {
      for (int column = 0; column <= row; ++column) {
        covariance_m2(row, column) = covariance_m2(column, row) = Scalar{triangle_m2(next++)};
      }
    }
    return covariance_m2;
  }

  /// The covariance's diagonal.
  Eigen::Matrix<float, Dim, 1> Variances_m2() const {
    Eigen::Matrix<float, Dim, 1> variances_m2;
    for (int row = 0; row < Dim; ++row) variances_m2(row) = triangle_m2(row * (row + 3) / 2);
    return variances_m2;
  }
};

}  // namespace dcloc
