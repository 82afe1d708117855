#pragma once

#include <Eigen/Core>
#include <span>

#include "core/calibration/return_pairs.h"
#include "core/calibration/static_return.h"

namespace dcloc {

/// What draws the two returns of each pair together, linear in the parameters; n of them,
/// kCalibrationParameters for each radar.
struct OverlapTerms {
  explicit OverlapTerms(Eigen::Index n)
      : hessian(Eigen::MatrixXd::Zero(n, n)),
        gradient(Eigen::VectorXd::Zero(n)),
        spread(Eigen::MatrixXd::Zero(n, n)) {}

  Eigen::MatrixXd hessian;
  Eigen::VectorXd gradient;  ///< hessian * step = gradient
  Eigen::MatrixXd spread;    ///< covariance of the gradient, from its blocks
};

struct OverlapOptions {
  double scatterer_sigma_m = 0.3;  ///< returns of one scatterer lie this far apart beyond noise
  double block_m = 8.0;            ///< squares of this size are taken to be independent
  double min_range_m = 0.0;        ///< pairs with a nearer return are left out
};

/// Adds the pairs of one frame to `terms`. Each pair weighs as much as the two overlap as
/// Gaussians, exp(-d^2 / 2) / sqrt(det S).
///
/// Both Jacobians are taken midway between the two. Neighbours that are not one scatterer then pull
/// as often one way as the other; at the returns' own places lines of sight diverge from one
/// neighbour to the next, and a rig that measures everything too near would win, because that
/// crowds the returns.
///
/// `parameters` (n) are in units of `scale` (n).
void AddOverlap(const FrameReturns& frame, std::span<const ReturnPair> pairs,
                const Eigen::VectorXd& parameters, const Eigen::VectorXd& scale,
                const OverlapOptions& options, OverlapTerms& terms);

}  // namespace dcloc
