#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "core/geometry/geodetic_anchor.h"
#include "core/geometry/pose.h"
#include "core/map/editable_map.h"

namespace dcloc {

/// The map in another frame, whose anchor it gets: every keyframe is moved, and no landmark moves
/// in its keyframe. FailedPrecondition where it would lie too far away for a map's file.
absl::StatusOr<EditableMap> MoveTo(const EditableMap& map, const Pose3& T_new_map,
                                   const std::optional<GeodeticAnchor>& anchor);

/// A place that is known in the map and on the Earth.
struct ControlPoint {
  Eigen::Vector2d p_map_m = Eigen::Vector2d::Zero();
  GeodeticPosition position;
};

/// Where control points put a map.
struct ControlFit {
  GeodeticAnchor anchor;
  std::vector<double> residual_m;  ///< of each point
  /// Of each point by the others alone: what the fit is worth elsewhere. Empty for two points.
  std::vector<double> left_out_m;
};

/// The anchor that brings all points together in the least squares sense; its height is the mean of
/// theirs. InvalidArgument for fewer than two points, or two that lie within a metre: they say
/// nothing of the heading.
absl::StatusOr<ControlFit> FitAnchor(std::span<const ControlPoint> points);

}  // namespace dcloc
