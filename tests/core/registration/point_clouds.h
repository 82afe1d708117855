#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <random>
#include <vector>

#include "core/geometry/gaussian_point.h"
#include "core/geometry/pose.h"

namespace dcloc {

template <int Dim>
using PointVector = Eigen::Matrix<double, Dim, 1>;
template <int Dim>
using PointMatrix = Eigen::Matrix<double, Dim, Dim>;

/// A vector of independent standard normal numbers.
template <int Size>
Eigen::Matrix<double, Size, 1> StandardNormal(std::mt19937& random) {
  std::normal_distribution<double> normal;
  Eigen::Matrix<double, Size, 1> z;
  for (int i = 0; i < Size; ++i) z(i) = normal(random);
  return z;
}

/// A draw from N(0, `covariance`).
template <int Size>
Eigen::Matrix<double, Size, 1> Draw(const Eigen::Matrix<double, Size, Size>& covariance,
                                    std::mt19937& random) {
  return covariance.llt().matrixL() * StandardNormal<Size>(random);
}

/// A positive definite matrix whose deviations lie around `sigma`, of random shape and direction.
template <int Dim>
PointMatrix<Dim> RandomCovariance(double sigma, std::mt19937& random) {
  PointMatrix<Dim> root;
  for (int column = 0; column < Dim; ++column) root.col(column) = StandardNormal<Dim>(random);
  return sigma * sigma * (0.2 * PointMatrix<Dim>::Identity() + 0.5 * root * root.transpose());
}

/// Points of a box of half-width `half_m` (a fifth of it upwards), no two within `apart_m`.
template <int Dim>
std::vector<PointVector<Dim>> SeparatedPoints(int count, double half_m, double apart_m,
                                              std::mt19937& random) {
  std::uniform_real_distribution<double> place_m(-half_m, half_m);
  std::vector<PointVector<Dim>> points;
  while (static_cast<int>(points.size()) < count) {
    PointVector<Dim> candidate;
    for (int i = 0; i < Dim; ++i) candidate(i) = i < 2 ? place_m(random) : 0.2 * place_m(random);
    bool far = true;
    for (const PointVector<Dim>& point : points) {
      far = far && (point - candidate).norm() >= apart_m;
    }
    if (far) points.push_back(candidate);
  }
  return points;
}

/// A small motion: (x, y, yaw) or in space, with some tilt.
template <int Dim>
Pose<Dim> SmallMotion(double translation_m, double rotation_rad) {
  Tangent<Dim> xi;
  if constexpr (Dim == 2) {
    xi << translation_m, -0.7 * translation_m, rotation_rad;
  } else {
    xi << translation_m, -0.7 * translation_m, 0.3 * translation_m, 0.4 * rotation_rad,
        -0.3 * rotation_rad, rotation_rad;
  }
  return Exp(xi);
}

/// Landmarks and the same places seen from `T_local_vehicle`, both with noise as their covariances
/// say; landmark i is live point i.
template <int Dim>
struct CloudPair {
  std::vector<GaussianPoint<Dim>> landmarks;
  std::vector<GaussianPoint<Dim>> live;
};

/// A pair without noise; covariances with deviations around `sigma_m`.
template <int Dim>
CloudPair<Dim> ExactPair(const Pose<Dim>& T_local_vehicle, int count, double sigma_m,
                         std::mt19937& random) {
  CloudPair<Dim> pair;
  for (const PointVector<Dim>& p_local : SeparatedPoints<Dim>(count, 40.0, 4.0, random)) {
    pair.landmarks.push_back({p_local, RandomCovariance<Dim>(sigma_m, random)});
    pair.live.push_back(
        {T_local_vehicle.Inverse() * p_local, RandomCovariance<Dim>(sigma_m, random)});
  }
  return pair;
}

/// `exact` with noise on both clouds.
template <int Dim>
CloudPair<Dim> Noisy(CloudPair<Dim> exact, std::mt19937& random) {
  for (auto* cloud : {&exact.landmarks, &exact.live}) {
    for (GaussianPoint<Dim>& point : *cloud) {
      point.mean_m += Draw<Dim>(point.covariance_m2, random);
    }
  }
  return exact;
}

}  // namespace dcloc
