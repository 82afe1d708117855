#pragma once

#include <array>

namespace dcloc::client {

using Vector3 = std::array<double, 3>;
/// A twist, or a tangent of a pose: (x, y, z, about x, about y, about z).
using Vector6 = std::array<double, 6>;
/// Row-major, of what Vector6 holds.
using Matrix6 = std::array<double, 36>;

/// Rigid transform from a child to its parent frame, `p_parent = rotation * p_child + translation`.
struct RigidPose {
  Vector3 translation_m{};
  std::array<double, 4> rotation_wxyz{1.0, 0.0, 0.0, 0.0};  ///< of unit norm
};

Vector3 operator+(const Vector3& a, const Vector3& b);
Vector3 operator-(const Vector3& a, const Vector3& b);
Vector3 operator*(double factor, const Vector3& a);
Vector6 operator+(const Vector6& a, const Vector6& b);
Vector6 operator-(const Vector6& a, const Vector6& b);
Vector6 operator*(double factor, const Vector6& a);
Vector3 Cross(const Vector3& a, const Vector3& b);
double Norm(const Vector3& a);

/// `T_a_c = T_a_b * T_b_c`.
RigidPose operator*(const RigidPose& T_a_b, const RigidPose& T_b_c);
RigidPose Inverse(const RigidPose& T);
Vector3 Rotate(const RigidPose& T, const Vector3& v);
/// The child's x, y and z axes in the parent frame: the columns of its rotation matrix.
std::array<Vector3, 3> Axes(const RigidPose& T);

/// Exponential map of SE(3): where a constant twist leads in a second.
RigidPose Exp(const Vector6& xi);
/// Its inverse; the rotation part has a norm of at most pi.
Vector6 Log(const RigidPose& T);

/// Covariance, about its parent's axes, of a pose that is rigidly tied to one with `covariance` and
/// lies `offset_m` from it: what is not known of the rotation moves what is far away.
Matrix6 MoveCovariance(const Matrix6& covariance, const Vector3& offset_m);

/// Adds variances along and about the axes of `T`, independent of each other.
void AddVariances(const RigidPose& T, const Vector6& variances, Matrix6& covariance);

}  // namespace dcloc::client
