#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace dcloc {

/// A place in the plane, and where a further return of what is there may lie.
struct PlaceEstimate {
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance_m2 = Eigen::Matrix2d::Identity();
};

struct CenterMatchingOptions {
  double gate = 9.2;     ///< squared Mahalanobis distance: 99 % of two places of one scatterer
  double max_m = 0.5;    ///< however uncertain both are
  double pose_m = 0.03;  ///< deviation by the pose of a pass, which all its centers share
};

inline constexpr std::uint32_t kNoCenter = std::numeric_limits<std::uint32_t>::max();

/// Of each landmark the center that is the same scatterer, or `kNoCenter`. One to one; the most
/// likely pairs first.
std::vector<std::uint32_t> MatchCenters(std::span<const PlaceEstimate> landmarks,
                                        std::span<const PlaceEstimate> centers,
                                        const CenterMatchingOptions& options = {});

}  // namespace dcloc
