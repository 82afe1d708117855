#pragma once

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <memory>
#include <numbers>

#include "core/geometry/pose.h"

namespace dcloc {

/// How Ceres holds a `Pose<Dim>`: (x, y, yaw), or (x, y, z, qx, qy, qz, qw).
template <int Dim>
inline constexpr int kParameters = Dim == 2 ? 3 : 7;

inline Eigen::Vector3d ToParameters(const Pose2& T) {
  return {T.translation_m.x(), T.translation_m.y(), T.yaw_rad};
}
inline Eigen::Matrix<double, 7, 1> ToParameters(const Pose3& T) {
  Eigen::Matrix<double, 7, 1> parameters;
  parameters << T.translation_m, T.rotation.coeffs();
  return parameters;
}
inline Pose2 FromParameters(const Eigen::Vector3d& parameters) {
  return {.translation_m = parameters.head<2>(), .yaw_rad = WrapAngle(parameters.z())};
}
inline Pose3 FromParameters(const Eigen::Matrix<double, 7, 1>& parameters) {
  return {.translation_m = parameters.head<3>(),
          .rotation = Eigen::Quaterniond(parameters.tail<4>()).normalized()};
}

/// Whitened residual of an edge (METHOD eq 16): the measured relative pose against that of two
/// states, turned to the measurement's right so that its covariance applies; q_w >= 0 is enforced.
template <int Dim>
class EdgeResidual {
 public:
  EdgeResidual(const Pose<Dim>& measured_from_to, const TangentMatrix<Dim>& covariance)
      : measured_(ToParameters(measured_from_to)),
        whitening_(TangentMatrix<Dim>(covariance.llt().matrixL())
                       .template triangularView<Eigen::Lower>()
                       .solve(TangentMatrix<Dim>::Identity())) {}

  static std::unique_ptr<ceres::CostFunction> Make(const Pose<Dim>& measured_from_to,
                                                   const TangentMatrix<Dim>& covariance) {
    return std::make_unique<ceres::AutoDiffCostFunction<EdgeResidual, Pose<Dim>::kDof,
                                                        kParameters<Dim>, kParameters<Dim>>>(
        new EdgeResidual(measured_from_to, covariance));
  }

  /// The same from the map's own frame, which is not sought: fewer derivatives.
  static std::unique_ptr<ceres::CostFunction> MakeFromMap(const Pose<Dim>& measured_map_to,
                                                          const TangentMatrix<Dim>& covariance) {
    return std::make_unique<
        ceres::AutoDiffCostFunction<EdgeResidual, Pose<Dim>::kDof, kParameters<Dim>>>(
        new EdgeResidual(measured_map_to, covariance));
  }

  template <typename T>
  bool operator()(const T* to, T* residual) const {
    const Eigen::Matrix<T, kParameters<Dim>, 1> map = ToParameters(Pose<Dim>()).template cast<T>();
    return (*this)(map.data(), to, residual);
  }

  template <typename T>
  bool operator()(const T* from, const T* to, T* residual) const {
    Eigen::Map<Eigen::Matrix<T, Pose<Dim>::kDof, 1>> r(residual);
    if constexpr (Dim == 2) {
      r = whitening_.template cast<T>() * PlanarDifference(from, to);
    } else {
      r = whitening_.template cast<T>() * SpatialDifference(from, to);
    }
    return true;
  }

 private:
  template <typename T>
  Eigen::Matrix<T, 3, 1> PlanarDifference(const T* from, const T* to) const {
    const T dx = to[0] - from[0];
    const T dy = to[1] - from[1];
    const T c = ceres::cos(from[2]);
    const T s = ceres::sin(from[2]);
    const T ex = c * dx + s * dy - measured_(0);
    const T ey = -s * dx + c * dy - measured_(1);
    const double cm = std::cos(measured_(2));
    const double sm = std::sin(measured_(2));
    T yaw = to[2] - from[2] - measured_(2);
    // Whole turns are constants to the derivative.
    while (yaw > T(std::numbers::pi)) yaw -= T(2.0 * std::numbers::pi);
    while (yaw < T(-std::numbers::pi)) yaw += T(2.0 * std::numbers::pi);
    return {cm * ex + sm * ey, -sm * ex + cm * ey, yaw};
  }

  template <typename T>
  Eigen::Matrix<T, 6, 1> SpatialDifference(const T* from, const T* to) const {
    using Vector3 = Eigen::Matrix<T, 3, 1>;
    using Quaternion = Eigen::Quaternion<T>;
    const Eigen::Map<const Vector3> t_from(from);
    const Eigen::Map<const Vector3> t_to(to);
    const Eigen::Map<const Quaternion> q_from(from + 3);
    const Eigen::Map<const Quaternion> q_to(to + 3);
    const Eigen::Quaterniond measured(measured_.template tail<4>());
    const Vector3 e = q_from.conjugate() * Vector3(t_to - t_from) -
                      measured_.template head<3>().template cast<T>();
    const Quaternion dq = measured.conjugate().template cast<T>() * (q_from.conjugate() * q_to);
    Eigen::Matrix<T, 6, 1> difference;
    difference.template head<3>() = measured.conjugate().template cast<T>() * e;
    difference.template tail<3>() = T(dq.w() < T(0.0) ? -2.0 : 2.0) * dq.vec();
    return difference;
  }

  Eigen::Matrix<double, kParameters<Dim>, 1> measured_;
  TangentMatrix<Dim> whitening_;
};

}  // namespace dcloc
