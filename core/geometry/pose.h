#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace dcloc {

/// Rigid transform `T_parent_child` in the plane (Dim = 2) or in space (Dim = 3), in double:
/// `p_parent = T_parent_child * p_child`. Inner frames cancel: `T_a_c = T_a_b * T_b_c`.
///
/// Tangent vectors are ordered (translation [m], rotation [rad]) and perturb on the right:
/// `T Exp(xi)`. The plane has 3 degrees of freedom (x, y, yaw), space has 6.
template <int Dim>
struct Pose;

template <>
struct Pose<2> {
  static constexpr int kDof = 3;
  Eigen::Vector2d translation_m = Eigen::Vector2d::Zero();
  double yaw_rad = 0.0;

  Eigen::Matrix2d Rotation() const { return Eigen::Rotation2Dd(yaw_rad).toRotationMatrix(); }
  Pose Inverse() const;
};

template <>
struct Pose<3> {
  static constexpr int kDof = 6;
  Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();

  Eigen::Matrix3d Rotation() const { return rotation.toRotationMatrix(); }
  Pose Inverse() const;
};

using Pose2 = Pose<2>;
using Pose3 = Pose<3>;

/// Tangent vector and its covariance for `Pose<Dim>`.
template <int Dim>
using Tangent = Eigen::Matrix<double, Pose<Dim>::kDof, 1>;
template <int Dim>
using TangentMatrix = Eigen::Matrix<double, Pose<Dim>::kDof, Pose<Dim>::kDof>;

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

Pose2 operator*(const Pose2& T_a_b, const Pose2& T_b_c);
Pose3 operator*(const Pose3& T_a_b, const Pose3& T_b_c);

Eigen::Vector2d operator*(const Pose2& T_a_b, const Eigen::Vector2d& p_b);
Eigen::Vector3d operator*(const Pose3& T_a_b, const Eigen::Vector3d& p_b);

/// `angle_rad` brought into (-pi, pi].
double WrapAngle(double angle_rad);

/// Cross-product matrix: `Skew(a) * b == a.cross(b)`.
Eigen::Matrix3d Skew(const Eigen::Vector3d& a);

/// Exponential maps of SE(2) and SE(3).
Pose2 Exp(const Eigen::Vector3d& xi);
Pose3 Exp(const Vector6d& xi);

/// Logarithms; the rotation part lies in (-pi, pi], a vector of norm <= pi.
Eigen::Vector3d Log(const Pose2& T);
Vector6d Log(const Pose3& T);

/// Adjoint: `T Exp(xi) == Exp(Adjoint(T) xi) T`.
Eigen::Matrix3d Adjoint(const Pose2& T);
Matrix6d Adjoint(const Pose3& T);

/// The planar pose as a pose in space: z, roll and pitch are zero.
Pose3 Embed(const Pose2& T);

/// The part of `T` in its parent's xy plane: x, y and the heading of the child's x axis.
Pose2 Flatten(const Pose3& T);

/// Heading of the child's x axis in the parent's xy plane [rad].
double Yaw(const Eigen::Quaterniond& rotation);

/// Angle of the whole rotation, in [0, pi].
double RotationAngle(const Pose2& T);
double RotationAngle(const Pose3& T);

}  // namespace dcloc
