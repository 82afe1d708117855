#include "core/passes/center_matching.h"

#include <Eigen/LU>
#include <cmath>

#include "core/map/point_grid.h"

namespace dcloc {

namespace {

/// Equation 62: `own` is the sum of exp(-d^2 / 2) of the `count` > 0 centers within the gate.
double PositionRatio(double gate, double own, int count) {
  const double others = count - 1.0;
  const double alone = others > 0.0 ? -std::expm1(-others) / others : 1.0;
  return 0.5 * gate * alone * own;
}

}  // namespace

std::vector<CenterMatch> MatchCenters(std::span<const LandmarkPosition> landmarks,
                                      std::span<const LandmarkPosition> centers,
                                      const CenterMatchingOptions& options) {
  PointGrid grid(1.0);
  for (const LandmarkPosition& center : centers) grid.Insert(center.position_m);
  const Eigen::Matrix2d pose = options.pose_m * options.pose_m * Eigen::Matrix2d::Identity();
  std::vector<CenterMatch> matches;
  matches.reserve(landmarks.size());
  for (const LandmarkPosition& landmark : landmarks) {
    CenterMatch best;
    double own = 0.0;
    int count = 0;
    double best_cost = std::numeric_limits<double>::infinity();
    grid.ForEachNear(landmark.position_m, Eigen::Vector2d::Constant(options.max_m),
                     [&](std::uint32_t c) {
                       const Eigen::Vector2d offset_m = centers[c].position_m - landmark.position_m;
                       if (offset_m.norm() > options.max_m) return;
                       const Eigen::Matrix2d covariance =
                           landmark.covariance_m2 + centers[c].covariance_m2 + pose;
                       const double squared = offset_m.dot(covariance.inverse() * offset_m);
                       if (squared > options.gate) return;
                       own += std::exp(-0.5 * squared);
                       ++count;
                       const double cost = squared + std::log(covariance.determinant());
                       if (cost >= best_cost) return;
                       best.center = c;
                       best_cost = cost;
                     });
    if (count > 0) best.position_ratio = PositionRatio(options.gate, own, count);
    matches.push_back(best);
  }
  return matches;
}

}  // namespace dcloc
