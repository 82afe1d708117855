#include "core/update/center_matching.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/map/point_grid.h"

namespace dcloc {

std::vector<std::uint32_t> MatchCenters(std::span<const PlaceEstimate> landmarks,
                                        std::span<const PlaceEstimate> centers,
                                        const CenterMatchingOptions& options) {
  PointGrid grid(1.0);
  for (const PlaceEstimate& center : centers) grid.Insert(center.position_m);
  using Pair = std::tuple<double, std::uint32_t, std::uint32_t>;  // cost, landmark, center
  std::vector<Pair> pairs;
  const Eigen::Matrix2d pose = options.pose_m * options.pose_m * Eigen::Matrix2d::Identity();
  for (std::uint32_t i = 0; i < landmarks.size(); ++i) {
    const PlaceEstimate& landmark = landmarks[i];
    grid.ForEachNear(landmark.position_m, Eigen::Vector2d::Constant(options.max_m),
                     [&](std::uint32_t c) {
                       const Eigen::Vector2d offset_m = centers[c].position_m - landmark.position_m;
                       if (offset_m.norm() > options.max_m) return;
                       const Eigen::Matrix2d covariance =
                           landmark.covariance_m2 + centers[c].covariance_m2 + pose;
                       const double squared = offset_m.dot(covariance.inverse() * offset_m);
                       if (squared > options.gate) return;
                       pairs.emplace_back(squared + std::log(covariance.determinant()), i, c);
                     });
  }
  std::ranges::sort(pairs);
  std::vector<std::uint32_t> center_of(landmarks.size(), kNoCenter);
  std::vector<bool> is_taken(centers.size(), false);
  for (const auto& [cost, landmark, center] : pairs) {
    if (center_of[landmark] != kNoCenter || is_taken[center]) continue;
    center_of[landmark] = center;
    is_taken[center] = true;
  }
  return center_of;
}

}  // namespace dcloc
