#include "core/geometry/pose.h"

#include <cmath>
#include <numbers>

namespace dcloc {
namespace {

// Below this angle the closed forms divide two vanishing numbers; the series is exact to rounding.
constexpr double kSmallAngle_rad = 1e-4;

// V of SE(2): the translation of Exp is V(yaw) * rho. Returns (sin a / a, (1 - cos a) / a).
Eigen::Vector2d PlanarV(double angle_rad) {
  if (std::abs(angle_rad) < kSmallAngle_rad) {
    const double squared = angle_rad * angle_rad;
    return {1.0 - squared / 6.0, angle_rad / 2.0 * (1.0 - squared / 12.0)};
  }
  return {std::sin(angle_rad) / angle_rad, (1.0 - std::cos(angle_rad)) / angle_rad};
}

// Left Jacobian of SO(3), which is the V of SE(3).
Eigen::Matrix3d LeftJacobian(const Eigen::Vector3d& phi) {
  const double angle_rad = phi.norm();
  const Eigen::Matrix3d k = Skew(phi);
  double a = 0.5;
  double b = 1.0 / 6.0;
  if (angle_rad > kSmallAngle_rad) {
    const double squared = angle_rad * angle_rad;
    a = (1.0 - std::cos(angle_rad)) / squared;
    b = (angle_rad - std::sin(angle_rad)) / (squared * angle_rad);
  }
  return Eigen::Matrix3d::Identity() + a * k + b * k * k;
}

Eigen::Quaterniond ExpRotation(const Eigen::Vector3d& phi) {
  const double half_rad = 0.5 * phi.norm();
  // sin(h)/h has no trouble at zero but the division itself.
  const double scale = half_rad < kSmallAngle_rad ? 0.5 * (1.0 - half_rad * half_rad / 6.0)
                                                  : 0.5 * std::sin(half_rad) / half_rad;
  const Eigen::Vector3d v = scale * phi;
  return Eigen::Quaterniond(std::cos(half_rad), v.x(), v.y(), v.z()).normalized();
}

Eigen::Vector3d LogRotation(const Eigen::Quaterniond& rotation) {
  // q and -q are the same rotation; the one with w >= 0 has the shorter angle.
  const double sign = rotation.w() < 0.0 ? -1.0 : 1.0;
  const Eigen::Vector3d v = sign * rotation.vec();
  const double sin_half = v.norm();
  if (sin_half < kSmallAngle_rad) return 2.0 * v * (1.0 + sin_half * sin_half / 6.0);
  return 2.0 * std::atan2(sin_half, sign * rotation.w()) / sin_half * v;
}

}  // namespace

Pose2 Pose2::Inverse() const {
  return {.translation_m = Rotation().transpose() * -translation_m, .yaw_rad = -yaw_rad};
}

Pose3 Pose3::Inverse() const {
  const Eigen::Quaterniond inverse = rotation.conjugate();
  return {.translation_m = inverse * -translation_m, .rotation = inverse};
}

Pose2 operator*(const Pose2& T_a_b, const Pose2& T_b_c) {
  return {.translation_m = T_a_b * T_b_c.translation_m,
          .yaw_rad = WrapAngle(T_a_b.yaw_rad + T_b_c.yaw_rad)};
}

Pose3 operator*(const Pose3& T_a_b, const Pose3& T_b_c) {
  return {.translation_m = T_a_b * T_b_c.translation_m,
          .rotation = (T_a_b.rotation * T_b_c.rotation).normalized()};
}

Eigen::Vector2d operator*(const Pose2& T_a_b, const Eigen::Vector2d& p_b) {
  return T_a_b.Rotation() * p_b + T_a_b.translation_m;
}

Eigen::Vector3d operator*(const Pose3& T_a_b, const Eigen::Vector3d& p_b) {
  return T_a_b.rotation * p_b + T_a_b.translation_m;
}

double WrapAngle(double angle_rad) {
  const double wrapped = std::remainder(angle_rad, 2.0 * std::numbers::pi);
  return wrapped == -std::numbers::pi ? std::numbers::pi : wrapped;
}

Eigen::Matrix3d Skew(const Eigen::Vector3d& a) {
  Eigen::Matrix3d skew;
  skew << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return skew;
}

Pose2 Exp(const Eigen::Vector3d& xi) {
  const Eigen::Vector2d v = PlanarV(xi.z());
  return {.translation_m = {v.x() * xi.x() - v.y() * xi.y(), v.y() * xi.x() + v.x() * xi.y()},
          .yaw_rad = WrapAngle(xi.z())};
}

Pose3 Exp(const Vector6d& xi) {
  const Eigen::Vector3d phi = xi.tail<3>();
  return {.translation_m = LeftJacobian(phi) * xi.head<3>(), .rotation = ExpRotation(phi)};
}

Eigen::Vector3d Log(const Pose2& T) {
  const double yaw_rad = WrapAngle(T.yaw_rad);
  const Eigen::Vector2d v = PlanarV(yaw_rad);
  const double determinant = v.squaredNorm();
  const Eigen::Vector2d& t = T.translation_m;
  return {(v.x() * t.x() + v.y() * t.y()) / determinant,
          (v.x() * t.y() - v.y() * t.x()) / determinant, yaw_rad};
}

Vector6d Log(const Pose3& T) {
  Vector6d xi;
  xi.tail<3>() = LogRotation(T.rotation);
  xi.head<3>() = LeftJacobian(xi.tail<3>()).partialPivLu().solve(T.translation_m);
  return xi;
}

Eigen::Matrix3d Adjoint(const Pose2& T) {
  Eigen::Matrix3d adjoint = Eigen::Matrix3d::Identity();
  adjoint.topLeftCorner<2, 2>() = T.Rotation();
  adjoint(0, 2) = T.translation_m.y();
  adjoint(1, 2) = -T.translation_m.x();
  return adjoint;
}

Matrix6d Adjoint(const Pose3& T) {
  const Eigen::Matrix3d rotation = T.Rotation();
  Matrix6d adjoint = Matrix6d::Zero();
  adjoint.topLeftCorner<3, 3>() = rotation;
  adjoint.bottomRightCorner<3, 3>() = rotation;
  adjoint.topRightCorner<3, 3>() = Skew(T.translation_m) * rotation;
  return adjoint;
}

Pose3 Embed(const Pose2& T) {
  return {.translation_m = {T.translation_m.x(), T.translation_m.y(), 0.0},
          .rotation = Eigen::Quaterniond(Eigen::AngleAxisd(T.yaw_rad, Eigen::Vector3d::UnitZ()))};
}

Pose2 Flatten(const Pose3& T) {
  return {.translation_m = T.translation_m.head<2>(), .yaw_rad = Yaw(T.rotation)};
}

double Yaw(const Eigen::Quaterniond& rotation) {
  const Eigen::Vector3d x_axis = rotation * Eigen::Vector3d::UnitX();
  return std::atan2(x_axis.y(), x_axis.x());
}

double RotationAngle(const Pose2& T) { return std::abs(WrapAngle(T.yaw_rad)); }

double RotationAngle(const Pose3& T) { return LogRotation(T.rotation).norm(); }

}  // namespace dcloc
