#include "core/registration/gicp.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace dcloc {
namespace {

template <int Dim>
using Vector = Eigen::Matrix<double, Dim, 1>;
template <int Dim>
using Matrix = Eigen::Matrix<double, Dim, Dim>;
template <int Dim>
using PointJacobian = Eigen::Matrix<double, Dim, Pose<Dim>::kDof>;

// A live point with its landmark, and the information of their difference.
template <int Dim>
struct Match {
  std::size_t live = 0;
  Vector<Dim> q = Vector<Dim>::Zero();
  Matrix<Dim> information = Matrix<Dim>::Zero();
};

// d (T Exp(xi) p) / d xi at zero.
template <int Dim>
PointJacobian<Dim> MoveJacobian(const Matrix<Dim>& R, const Vector<Dim>& p) {
  PointJacobian<Dim> G;
  G.template leftCols<Dim>() = R;
  if constexpr (Dim == 2) {
    G.col(2) = R * Eigen::Vector2d(-p.y(), p.x());
  } else {
    G.template rightCols<3>() = -R * Skew(p);
  }
  return G;
}

template <int Dim>
std::vector<Match<Dim>> FindMatches(std::span<const GaussianPoint<Dim>> live,
                                    const LocalMap<Dim>& map, const Pose<Dim>& T, double blur_m,
                                    const GicpOptions& options) {
  const Matrix<Dim> R = T.Rotation();
  const double gate = options.gate_sigmas * options.gate_sigmas;
  std::vector<Match<Dim>> matches;
  matches.reserve(live.size());
  for (std::size_t i = 0; i < live.size(); ++i) {
    const Vector<Dim> p = R * live[i].mean_m + T.translation_m;
    const Matrix<Dim> covariance =
        R * live[i].covariance_m2 * R.transpose() + blur_m * blur_m * Matrix<Dim>::Identity();
    double best = std::numeric_limits<double>::infinity();
    Match<Dim> match;
    map.ForEachNear(p.x(), p.y(), options.reach_m, [&](std::size_t index) {
      const GaussianPoint<Dim>& landmark = map.points()[index];
      const Vector<Dim> e = landmark.mean_m - p;
      if (e.squaredNorm() > options.reach_m * options.reach_m) return;
      const Matrix<Dim> joint = landmark.covariance_m2 + covariance;
      const Matrix<Dim> information = joint.inverse();
      const double distance = e.dot(information * e);
      if (distance > gate) return;
      // Negative log-likelihood: a wide landmark does not win by its width alone.
      const double cost = distance + std::log(joint.determinant());
      if (cost < best) {
        best = cost;
        match = {i, landmark.mean_m, information};
      }
    });
    if (std::isfinite(best)) matches.push_back(match);
  }
  return matches;
}

double HuberCost(double squared, double k) {
  return squared <= k * k ? squared : 2.0 * k * std::sqrt(squared) - k * k;
}

double HuberWeight(double squared, double k) {
  return squared <= k * k ? 1.0 : k / std::sqrt(squared);
}

template <int Dim>
double Cost(std::span<const GaussianPoint<Dim>> live, const std::vector<Match<Dim>>& matches,
            const Pose<Dim>& T, double huber) {
  const Matrix<Dim> R = T.Rotation();
  double cost = 0.0;
  for (const Match<Dim>& match : matches) {
    const Vector<Dim> e = match.q - (R * live[match.live].mean_m + T.translation_m);
    cost += HuberCost(e.dot(match.information * e), huber);
  }
  return cost;
}

// The quadratic around T, and what its covariance and quality need.
template <int Dim>
struct NormalEquations {
  TangentMatrix<Dim> hessian = TangentMatrix<Dim>::Zero();
  TangentMatrix<Dim> squared_weights = TangentMatrix<Dim>::Zero();  // sum w^2 G^T W G
  Tangent<Dim> gradient = Tangent<Dim>::Zero();
  double cost = 0.0;
  double squared_residuals = 0.0;
  double likelihood = 0.0;  // sum exp(-d^2 / 2)
};

template <int Dim>
NormalEquations<Dim> Linearize(std::span<const GaussianPoint<Dim>> live,
                               const std::vector<Match<Dim>>& matches, const Pose<Dim>& T,
                               double huber) {
  const Matrix<Dim> R = T.Rotation();
  NormalEquations<Dim> normal;
  for (const Match<Dim>& match : matches) {
    const Vector<Dim>& p = live[match.live].mean_m;
    const Vector<Dim> e = match.q - (R * p + T.translation_m);
    const double squared = e.dot(match.information * e);
    const double weight = HuberWeight(squared, huber);
    const PointJacobian<Dim> G = MoveJacobian<Dim>(R, p);
    const TangentMatrix<Dim> outer = G.transpose() * match.information * G;
    normal.hessian += weight * outer;
    normal.squared_weights += weight * weight * outer;
    normal.gradient -= weight * (G.transpose() * (match.information * e));
    normal.cost += HuberCost(squared, huber);
    normal.squared_residuals += squared;
    normal.likelihood += std::exp(-0.5 * squared);
  }
  return normal;
}

// One Levenberg-Marquardt step on frozen matches: raises the damping until the cost falls.
template <int Dim>
Tangent<Dim> Step(std::span<const GaussianPoint<Dim>> live, const std::vector<Match<Dim>>& matches,
                  const NormalEquations<Dim>& normal, double huber, Pose<Dim>& T) {
  double damping = 1e-6;
  for (int attempt = 0; attempt < 6; ++attempt, damping *= 30.0) {
    TangentMatrix<Dim> damped = normal.hessian;
    damped.diagonal() += damping * normal.hessian.diagonal().cwiseMax(1e-3);
    const Tangent<Dim> step = -damped.ldlt().solve(normal.gradient);
    const Pose<Dim> candidate = T * Exp(step);
    if (Cost(live, matches, candidate, huber) <= normal.cost) {
      T = candidate;
      return step;
    }
  }
  return Tangent<Dim>::Zero();
}

// H^-1 (sum w^2 G^T W G) H^-1, direction by direction, so that what is not observed says so.
template <int Dim>
TangentMatrix<Dim> SandwichCovariance(const NormalEquations<Dim>& normal) {
  const Eigen::SelfAdjointEigenSolver<TangentMatrix<Dim>> solver(normal.hessian);
  constexpr double kMinInformation = 1.0 / kUnobserved;
  const Tangent<Dim> values = solver.eigenvalues().cwiseMax(kMinInformation);
  const TangentMatrix<Dim> inverse = solver.eigenvectors() * values.cwiseInverse().asDiagonal() *
                                     solver.eigenvectors().transpose();
  TangentMatrix<Dim> covariance = inverse * normal.squared_weights * inverse;
  for (int i = 0; i < Pose<Dim>::kDof; ++i) {
    if (solver.eigenvalues()(i) > kMinInformation) continue;
    const Tangent<Dim> direction = solver.eigenvectors().col(i);
    covariance += kUnobserved * direction * direction.transpose();
  }
  return 0.5 * (covariance + covariance.transpose());
}

}  // namespace

template <int Dim>
Registration<Dim> RegisterGicp(std::span<const GaussianPoint<Dim>> live, const LocalMap<Dim>& map,
                               const Pose<Dim>& T_local_vehicle_initial,
                               const GicpOptions& options) {
  Registration<Dim> result;
  result.T_local_vehicle = T_local_vehicle_initial;
  double blur_m = options.initial_blur_m;
  constexpr double kNoBlur_m = 0.02;
  std::vector<Match<Dim>> matches;
  NormalEquations<Dim> normal;
  while (true) {
    matches = FindMatches(live, map, result.T_local_vehicle, blur_m, options);
    normal = Linearize(live, matches, result.T_local_vehicle, options.huber_sigmas);
    if (result.converged || result.iterations == options.max_iterations) break;
    if (matches.size() < static_cast<std::size_t>(Pose<Dim>::kDof)) break;
    const Tangent<Dim> step =
        Step(live, matches, normal, options.huber_sigmas, result.T_local_vehicle);
    ++result.iterations;
    const bool sharp = blur_m == 0.0;
    blur_m = blur_m > kNoBlur_m ? 0.5 * blur_m : 0.0;
    result.converged =
        sharp && step.template head<Dim>().norm() < options.translation_tolerance_m &&
        step.template tail<Pose<Dim>::kDof - Dim>().norm() < options.rotation_tolerance_rad;
  }
  const auto inlier_count = static_cast<double>(matches.size());
  result.covariance = SandwichCovariance<Dim>(normal);
  result.inlier_count = static_cast<int>(matches.size());
  if (matches.empty()) return result;
  result.overlap = inlier_count / static_cast<double>(live.size());
  result.score = normal.likelihood / static_cast<double>(live.size());
  result.residual_scale = std::sqrt(normal.squared_residuals / (Dim * inlier_count));
  return result;
}

template Registration<2> RegisterGicp<2>(std::span<const GaussianPoint<2>>, const LocalMap<2>&,
                                         const Pose2&, const GicpOptions&);
template Registration<3> RegisterGicp<3>(std::span<const GaussianPoint<3>>, const LocalMap<3>&,
                                         const Pose3&, const GicpOptions&);

}  // namespace dcloc
