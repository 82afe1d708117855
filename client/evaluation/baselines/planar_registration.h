#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/gaussian_point.h"
#include "core/geometry/pose.h"
#include "core/map/local_map.h"
#include "core/radar/static_points.h"

namespace dcloc {

/// A registration of a sub-map in a local map.
struct PlanarFit {
  Pose2 T_local_vehicle;
  /// In the tangent space on the right; absent where the method does not know it.
  std::optional<Eigen::Matrix3d> covariance;
  int inlier_count = 0;
};

/// Another registration algorithm in the plane, with only the results that it provides itself.
class PlanarRegistration {
 public:
  virtual ~PlanarRegistration() = default;

  /// The pose of `points` (vehicle frame) in `map`, near `guess`; nothing when none is found.
  virtual std::optional<PlanarFit> Register(std::span<const GaussianPoint<2>> points,
                                            const LocalMap<2>& map, const Pose2& guess,
                                            std::uint64_t seed) const = 0;
};

/// The points in the plane.
std::vector<GaussianPoint<2>> InPlane(std::span<const RadarPoint> points);

}  // namespace dcloc
