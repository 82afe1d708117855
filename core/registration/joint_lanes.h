#pragma once

#include <Eigen/Core>
#include <array>

#include "core/geometry/lanes.h"
#include "core/map/packed_lanes.h"

namespace dcloc {

/// The sum of all `values` squared.
template <std::size_t N>
Lanes SquaredNorm(const std::array<Lanes, N>& values) {
  Lanes sum = values[0] * values[0];
  for (std::size_t i = 1; i < N; ++i) sum += values[i] * values[i];
  return sum;
}

/// The joint covariance of a live point and each of four landmarks.
template <int Dim>
class JointLanes;

template <>
class JointLanes<2> {
 public:
  /// `covariance_m2` is the live point's.
  JointLanes(const PackedLanes<2>& landmarks, const Eigen::Matrix2f& covariance_m2)
      : xx_(landmarks.triangle_m2[0] + covariance_m2(0, 0)),
        xy_(landmarks.triangle_m2[1] + covariance_m2(1, 0)),
        yy_(landmarks.triangle_m2[2] + covariance_m2(1, 1)) {}

  Lanes Determinant() const { return xx_ * yy_ - xy_ * xy_; }

  /// The squared Mahalanobis distance of `e_m`, times the determinant.
  Lanes ScaledSquare(const std::array<Lanes, 2>& e_m) const {
    return e_m[0] * (yy_ * e_m[0] - 2.0F * xy_ * e_m[1]) + xx_ * e_m[1] * e_m[1];
  }

  /// The trace of the inverse, times the determinant.
  Lanes ScaledInverseTrace() const { return xx_ + yy_; }

 private:
  Lanes xx_, xy_, yy_;
};

template <>
class JointLanes<3> {
 public:
  JointLanes(const PackedLanes<3>& landmarks, const Eigen::Matrix3f& covariance_m2) {
    const auto& triangle_m2 = landmarks.triangle_m2;
    xx_ = triangle_m2[0] + covariance_m2(0, 0);
    xy_ = triangle_m2[1] + covariance_m2(1, 0);
    xz_ = triangle_m2[3] + covariance_m2(2, 0);
    const Lanes yy = triangle_m2[2] + covariance_m2(1, 1);
    const Lanes yz = triangle_m2[4] + covariance_m2(2, 1);
    const Lanes zz = triangle_m2[5] + covariance_m2(2, 2);
    inverse_ = {yy * zz - yz * yz,    xz_ * yz - xy_ * zz,  xy_ * yz - xz_ * yy,
                xx_ * zz - xz_ * xz_, xy_ * xz_ - xx_ * yz, xx_ * yy - xy_ * xy_};
  }

  Lanes Determinant() const { return xx_ * inverse_[0] + xy_ * inverse_[1] + xz_ * inverse_[2]; }

  Lanes ScaledSquare(const std::array<Lanes, 3>& e_m) const {
    const auto& [x, y, z] = e_m;
    const auto& [xx, xy, xz, yy, yz, zz] = inverse_;
    return x * (xx * x + 2.0F * (xy * y + xz * z)) + y * (yy * y + 2.0F * yz * z) + z * zz * z;
  }

  Lanes ScaledInverseTrace() const { return inverse_[0] + inverse_[3] + inverse_[5]; }

 private:
  Lanes xx_, xy_, xz_;
  std::array<Lanes, 6> inverse_;  // xx, xy, xz, yy, yz, zz, times the determinant
};

}  // namespace dcloc
