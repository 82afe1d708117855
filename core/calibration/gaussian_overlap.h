#pragma once

#include <Eigen/Core>
#include <span>

#include "core/calibration/return_pairs.h"
#include "core/calibration/static_return.h"

namespace dcloc {

/// Normal equations of the pairs' overlap in the n parameters, kCalibrationParameters for each
/// radar.
struct OverlapTerms {
  explicit OverlapTerms(Eigen::Index n)
      : hessian(Eigen::MatrixXd::Zero(n, n)),
        gradient(Eigen::VectorXd::Zero(n)),
        spread(Eigen::MatrixXd::Zero(n, n)) {}

  Eigen::MatrixXd hessian;
  Eigen::VectorXd gradient;  ///< hessian * step = gradient
  Eigen::MatrixXd spread;    ///< covariance of the gradient, from its blocks
};

/// How overlap is counted in one round of a calibration (`CalibratorOptions` has the bounds).
struct OverlapKernel {
  double scatterer_sigma_m;  ///< returns of one scatterer lie this far apart beyond noise
  double block_m;            ///< squares of this size are taken to be independent
  double min_range_m;        ///< pairs with a nearer return are left out
};

/// Adds the pairs of one frame to `terms`. Each pair weighs as much as the two overlap as
/// Gaussians, exp(-d^2 / 2) / sqrt(det S).
///
/// Both Jacobians are taken at the middle of the two returns. Then pairs of two different
/// scatterers pull equally often in both directions. At the returns' own positions, the lines of
/// sight of neighbours diverge. The overlap would then grow with a range bias that pulls all
/// returns towards the radar.
///
/// `parameters` (n) are in units of `scale` (n).
void AddOverlap(const FrameReturns& frame, std::span<const ReturnPair> pairs,
                const Eigen::VectorXd& parameters, const Eigen::VectorXd& scale,
                const OverlapKernel& kernel, OverlapTerms& terms);

}  // namespace dcloc
