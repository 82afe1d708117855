#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace dcloc {

/// Where a landmark lies in the plane, and where a further return of it may lie.
struct LandmarkPosition {
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance_m2 = Eigen::Matrix2d::Identity();
};

struct CenterMatchingOptions {
  double gate = 9.2;    ///< squared Mahalanobis distance: 99 % of two positions of one scatterer
  double max_m = 0.8;   ///< however uncertain both are
  double pose_m = 0.1;  ///< deviation by the pose of a pass, which all its centers share
};

inline constexpr std::uint32_t kNoCenter = std::numeric_limits<std::uint32_t>::max();

struct CenterMatch {
  std::uint32_t center = kNoCenter;
  /// How much likelier the centers within the gate lie as they do if one is of the landmark than if
  /// all lie anywhere (equation 62). Where many lie, some lie near by chance.
  double position_ratio = 1.0;
};

/// Of each landmark the center that is most likely the same scatterer, or `kNoCenter`. Landmarks
/// that lie close together may have one center: a radar does not tell them apart in each pass.
std::vector<CenterMatch> MatchCenters(std::span<const LandmarkPosition> landmarks,
                                      std::span<const LandmarkPosition> centers,
                                      const CenterMatchingOptions& options = {});

}  // namespace dcloc
