#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <random>
#include <vector>

#include "core/geometry/pose.h"
#include "core/posegraph/pose_graph.h"

namespace dcloc {

/// A diagonal covariance: the same deviations for all translations and for all rotations.
template <int Dim>
TangentMatrix<Dim> Diagonal(double sigma_m, double sigma_rad) {
  Tangent<Dim> variances;
  variances.template head<Dim>().setConstant(sigma_m * sigma_m);
  variances.template tail<Pose<Dim>::kDof - Dim>().setConstant(sigma_rad * sigma_rad);
  return variances.asDiagonal();
}

/// A draw from N(0, `covariance`).
template <int Dim>
Tangent<Dim> DrawTangent(const TangentMatrix<Dim>& covariance, std::mt19937& random) {
  std::normal_distribution<double> normal;
  Tangent<Dim> z;
  for (double& value : z) value = normal(random);
  return covariance.llt().matrixL() * z;
}

/// One step of a vehicle: 0.8 m ahead in a bend, in space climbing a little.
template <int Dim>
Pose<Dim> StepAhead() {
  if constexpr (Dim == 2) {
    return Exp(Eigen::Vector3d(0.8, 0.02, 0.04));
  } else {
    Vector6d xi;
    xi << 0.8, 0.02, 0.01, 0.003, -0.005, 0.04;
    return Exp(xi);
  }
}

/// A vehicle's way with what odometry and registrations say about it, and the noise that they hold:
/// measured = true Exp(noise).
template <int Dim>
struct Chain {
  struct Step {
    Pose<Dim> truth;
    Tangent<Dim> odometry_noise;
    Tangent<Dim> loop_noise;
    PoseEstimate<Dim> odometry;  ///< from the step before
    AbsolutePoseFactor<Dim> factor;
  };
  PoseEstimate<Dim> prior;
  Tangent<Dim> prior_noise;
  std::vector<Step> steps;

  Chain(int count, const TangentMatrix<Dim>& odometry, const TangentMatrix<Dim>& loop,
        unsigned seed) {
    std::mt19937 random(seed);
    Pose<Dim> truth = Exp(Tangent<Dim>(Tangent<Dim>::Constant(0.3)));
    prior_noise = DrawTangent<Dim>(loop, random);
    prior = {truth * Exp(prior_noise), loop};
    for (int i = 0; i < count; ++i) {
      Step step;
      truth = truth * StepAhead<Dim>();
      step.truth = truth;
      step.odometry_noise = DrawTangent<Dim>(odometry, random);
      step.loop_noise = DrawTangent<Dim>(loop, random);
      step.odometry = {StepAhead<Dim>() * Exp(step.odometry_noise), odometry};
      step.factor = {truth * Exp(step.loop_noise), loop, loop};
      steps.push_back(step);
    }
  }
};

}  // namespace dcloc
