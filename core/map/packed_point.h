#pragma once

#include <Eigen/Core>

#include "core/geometry/gaussian_point.h"

namespace dcloc {

/// A GaussianPoint of a local map, in its frame, packed into single precision: at each scan a
/// tracker reads those around its vehicle, which the landmarks of all other vehicles have meanwhile
/// driven out of the processor's caches, so that their bytes cost as much as their arithmetic.
/// Places within 100 m of the frame's origin are held to 4 micrometres.
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

  /// Where a point of this slant (GaussianPoint::slant_per_m) sees it.
  template <typename Scalar>
  Eigen::Matrix<Scalar, Dim, 1> SeenBy(const Eigen::Matrix<Scalar, Dim, 1>& slant_per_m) const {
    return mean_m.template cast<Scalar>() + Scalar{height_square_m2} * slant_per_m;
  }

  Eigen::Matrix<double, Dim, Dim> Covariance_m2() const {
    Eigen::Matrix<double, Dim, Dim> covariance_m2;
    for (int row = 0, next = 0; row < Dim; ++row) {
      for (int column = 0; column <= row; ++column) {
        covariance_m2(row, column) = covariance_m2(column, row) = triangle_m2(next++);
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
