#pragma once

#include <Eigen/Core>
#include <array>

#include "core/geometry/lanes.h"
#include "core/map/packed_point.h"

namespace dcloc {

/// Four landmarks of a local map that follow each other, one in each lane.
template <int Dim>
struct PackedLanes {
  std::array<Lanes, Dim> mean_m;
  Lanes height_square_m2;
  /// The covariance's lower triangle, row by row.
  std::array<Lanes, Dim*(Dim + 1) / 2> triangle_m2;

  /// Reads `kLaneCount` points.
  explicit PackedLanes(const PackedPoint<Dim>* points)
      : height_square_m2(Of(points, [](const auto& point) { return point.height_square_m2; })) {
    for (std::size_t i = 0; i < mean_m.size(); ++i) {
      mean_m[i] = Of(points, [&](const auto& point) { return point.mean_m.data()[i]; });
    }
    for (std::size_t i = 0; i < triangle_m2.size(); ++i) {
      triangle_m2[i] = Of(points, [&](const auto& point) { return point.triangle_m2.data()[i]; });
    }
  }

  /// From `p_m` to where a live point there with this `GaussianPoint::slant_per_m` sees them.
  std::array<Lanes, Dim> SeenFrom(const Eigen::Matrix<float, Dim, 1>& p_m,
                                  const Eigen::Matrix<float, Dim, 1>& slant_per_m) const {
    std::array<Lanes, Dim> e_m;
    for (std::size_t i = 0; i < e_m.size(); ++i) {
      e_m[i] = (mean_m[i] + height_square_m2 * slant_per_m.data()[i]) - p_m.data()[i];
    }
    return e_m;
  }

  /// The covariances' diagonal elements.
  Lanes Variances_m2(int axis) const {
    return triangle_m2[static_cast<std::size_t>(axis * (axis + 3) / 2)];
  }

 private:
  template <typename Field>
  static Lanes Of(const PackedPoint<Dim>* points, const Field& field) {
    return Lanes{field(points[0]), field(points[1]), field(points[2]), field(points[3])};
  }
};

}  // namespace dcloc
