#include "core/update/center_matching.h"

#include <Eigen/LU>
#include <cmath>

#include "core/map/point_grid.h"

namespace dcloc {

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
    double best_cost = std::numeric_limits<double>::infinity();
    grid.ForEachNear(landmark.position_m, Eigen::Vector2d::Constant(options.max_m),
                     [&](std::uint32_t c) {
                       const Eigen::Vector2d offset_m = centers[c].position_m - landmark.position_m;
                       if (offset_m.norm() > options.max_m) return;
                       const Eigen::Matrix2d covariance =
                           landmark.covariance_m2 + centers[c].covariance_m2 + pose;
                       const double squared = offset_m.dot(covariance.inverse() * offset_m);
                       const double cost = squared + std::log(covariance.determinant());
                       if (squared > options.gate || cost >= best_cost) return;
                       best = {c, 0.5 * options.gate * std::exp(-0.5 * squared)};
                       best_cost = cost;
                     });
    matches.push_back(best);
  }
  return matches;
}

}  // namespace dcloc
