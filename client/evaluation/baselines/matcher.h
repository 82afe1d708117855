#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>

#include "core/geometry/pose.h"
#include "core/map/local_map.h"
#include "core/radar/static_points.h"

namespace dcloc {

/// How a live sub-map was found to lie in a local map.
struct Match {
  Pose2 T_local_vehicle;
  /// In the tangent space on the right; absent where the method does not know it.
  std::optional<Eigen::Matrix3d> covariance;
  int inlier_count = 0;
};

/// One way of registering a live sub-map.
class Matcher {
 public:
  virtual ~Matcher() = default;

  /// The pose of `live` (vehicle frame) in `map`, near `predicted`; nothing when none is found.
  virtual std::optional<Match> Find(std::span<const RadarPoint> live, const LocalMap<2>& map,
                                    const Pose2& predicted, std::uint64_t seed) const = 0;
};

}  // namespace dcloc
