#include "client/sdk/pose/rigid_pose.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace dcloc::client {
namespace {

using Quaternion = std::array<double, 4>;

constexpr double kSmallAngle_rad = 1e-6;

template <typename Vector, typename Operation>
Vector ForEach(const Vector& a, const Vector& b, Operation operation) {
  Vector result;
  std::transform(a.begin(), a.end(), b.begin(), result.begin(), operation);
  return result;
}

Vector3 Upper(const Vector6& a) { return {a[0], a[1], a[2]}; }
Vector3 Lower(const Vector6& a) { return {a[3], a[4], a[5]}; }

Vector3 RotateBy(const Quaternion& q, const Vector3& v) {
  const Vector3 u = {q[1], q[2], q[3]};
  const Vector3 twice = 2.0 * Cross(u, v);
  return v + q[0] * twice + Cross(u, twice);
}

Quaternion Multiply(const Quaternion& a, const Quaternion& b) {
  return {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
          a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
          a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
          a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
}

Quaternion Normalized(const Quaternion& q) {
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  return {q[0] / norm, q[1] / norm, q[2] / norm, q[3] / norm};
}

Quaternion Conjugate(const Quaternion& q) { return {q[0], -q[1], -q[2], -q[3]}; }

using Matrix3 = std::array<double, 9>;

Matrix3 Block(const Matrix6& m, std::size_t row, std::size_t column) {
  Matrix3 block;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) block[3 * i + j] = m[6 * (row + i) + column + j];
  }
  return block;
}

/// The matrix of `v -> v x offset`, times `m`.
Matrix3 CrossTimes(const Vector3& offset, const Matrix3& m) {
  Matrix3 result;
  for (std::size_t j = 0; j < 3; ++j) {
    const Vector3 column = Cross({m[j], m[3 + j], m[6 + j]}, offset);
    for (std::size_t i = 0; i < 3; ++i) result[3 * i + j] = column[i];
  }
  return result;
}

Matrix3 Transposed(const Matrix3& m) {
  return {m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]};
}

}  // namespace

Vector3 operator+(const Vector3& a, const Vector3& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
Vector3 operator-(const Vector3& a, const Vector3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Vector3 operator*(double factor, const Vector3& a) {
  return {factor * a[0], factor * a[1], factor * a[2]};
}
Vector6 operator+(const Vector6& a, const Vector6& b) {
  return ForEach(a, b, [](double x, double y) { return x + y; });
}
Vector6 operator-(const Vector6& a, const Vector6& b) {
  return ForEach(a, b, [](double x, double y) { return x - y; });
}
Vector6 operator*(double factor, const Vector6& a) {
  return ForEach(a, a, [factor](double x, double) { return factor * x; });
}

Vector3 Cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double Norm(const Vector3& a) { return std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]); }

RigidPose operator*(const RigidPose& T_a_b, const RigidPose& T_b_c) {
  return {T_a_b.translation_m + RotateBy(T_a_b.rotation_wxyz, T_b_c.translation_m),
          Normalized(Multiply(T_a_b.rotation_wxyz, T_b_c.rotation_wxyz))};
}

RigidPose Inverse(const RigidPose& T) {
  const Quaternion inverse = Conjugate(T.rotation_wxyz);
  return {-1.0 * RotateBy(inverse, T.translation_m), inverse};
}

Vector3 Rotate(const RigidPose& T, const Vector3& v) { return RotateBy(T.rotation_wxyz, v); }

std::array<Vector3, 3> Axes(const RigidPose& T) {
  return {Rotate(T, {1.0, 0.0, 0.0}), Rotate(T, {0.0, 1.0, 0.0}), Rotate(T, {0.0, 0.0, 1.0})};
}

RigidPose Exp(const Vector6& xi) {
  const Vector3 way = Upper(xi);
  const Vector3 turn = Lower(xi);
  const double angle_rad = Norm(turn);
  const double half_rad = 0.5 * angle_rad;
  const bool is_small = angle_rad < kSmallAngle_rad;
  const double square = angle_rad * angle_rad;
  const double sine_share = is_small ? 0.5 : std::sin(half_rad) / angle_rad;
  const double first = is_small ? 0.5 : (1.0 - std::cos(angle_rad)) / square;
  const double second =
      is_small ? 1.0 / 6.0 : (angle_rad - std::sin(angle_rad)) / (square * angle_rad);
  const Vector3 across = Cross(turn, way);
  return {way + first * across + second * Cross(turn, across),
          {std::cos(half_rad), sine_share * turn[0], sine_share * turn[1], sine_share * turn[2]}};
}

Vector6 Log(const RigidPose& T) {
  Quaternion q = T.rotation_wxyz;
  if (q[0] < 0.0) q = {-q[0], -q[1], -q[2], -q[3]};
  const Vector3 u = {q[1], q[2], q[3]};
  const double sine = Norm(u);
  const double angle_rad = 2.0 * std::atan2(sine, q[0]);
  const bool is_small = angle_rad < kSmallAngle_rad;
  const Vector3 turn = (is_small ? 2.0 : angle_rad / sine) * u;
  const double half_rad = 0.5 * angle_rad;
  const double share = is_small ? 1.0 / 12.0
                                : (1.0 - half_rad * std::cos(half_rad) / std::sin(half_rad)) /
                                      (angle_rad * angle_rad);
  const Vector3 across = Cross(turn, T.translation_m);
  const Vector3 way = T.translation_m - 0.5 * across + share * Cross(turn, across);
  return {way[0], way[1], way[2], turn[0], turn[1], turn[2]};
}

Matrix6 MoveCovariance(const Matrix6& covariance, const Vector3& offset_m) {
  // position' = position + rotation x offset; with M the matrix of that cross product:
  const Matrix3 position_rotation = Block(covariance, 0, 3);
  const Matrix3 rotation = Block(covariance, 3, 3);
  const Matrix3 M_rotation = CrossTimes(offset_m, rotation);
  const Matrix3 M_cross = CrossTimes(offset_m, Transposed(position_rotation));
  const Matrix3 M_rotation_M = Transposed(CrossTimes(offset_m, Transposed(M_rotation)));
  Matrix6 moved = covariance;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      moved[6 * i + j] += M_cross[3 * i + j] + M_cross[3 * j + i] + M_rotation_M[3 * i + j];
      moved[6 * i + 3 + j] += M_rotation[3 * i + j];
      moved[6 * (3 + j) + i] = moved[6 * i + 3 + j];
    }
  }
  return moved;
}

void AddVariances(const RigidPose& T, const Vector6& variances, Matrix6& covariance) {
  const std::array<Vector3, 3> axes = Axes(T);
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double product = axes[axis][i] * axes[axis][j];
        covariance[6 * i + j] += variances[axis] * product;
        covariance[6 * (3 + i) + 3 + j] += variances[3 + axis] * product;
      }
    }
  }
}

}  // namespace dcloc::client
