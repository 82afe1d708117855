#include "core/map/map_frame.h"

#include <algorithm>

#include "absl/strings/str_format.h"
#include "core/geometry/rigid_fit.h"
#include "core/map/map_content.h"

namespace dcloc {
namespace {

constexpr double kMinSpread_m = 1.0;

Eigen::Vector2d InMap(const GeodeticAnchor& anchor, const GeodeticPosition& position) {
  return MapFromGeodetic(anchor, position).head<2>();
}

/// The anchor's plane turns and shifts until the points meet. The Earth is round, so again.
GeodeticAnchor FitOnce(std::span<const ControlPoint> points) {
  GeodeticAnchor anchor{.origin = points.front().position};
  for (int round = 0; round < 4; ++round) {
    std::vector<PlacePair> pairs;
    for (const ControlPoint& point : points) {
      pairs.push_back({InMap(anchor, point.position), point.p_map_m});
    }
    const Pose2 T_anchor_map = FitRigid(pairs);
    Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
    origin_m.head<2>() = T_anchor_map.translation_m;
    const GeodeticPosition origin = GeodeticFromMap(anchor, origin_m);
    anchor = {.origin = origin,
              .x_axis_east_rad = WrapAngle(anchor.x_axis_east_rad + T_anchor_map.yaw_rad)};
  }
  double height_m = 0.0;
  for (const ControlPoint& point : points) height_m += point.position.height_m;
  anchor.origin.height_m = height_m / static_cast<double>(points.size());
  return anchor;
}

double Distance_m(const GeodeticAnchor& anchor, const ControlPoint& point) {
  return (InMap(anchor, point.position) - point.p_map_m).norm();
}

double Spread_m(std::span<const ControlPoint> points) {
  double spread_m = 0.0;
  for (const ControlPoint& point : points) {
    spread_m = std::max(spread_m, (point.p_map_m - points.front().p_map_m).norm());
  }
  return spread_m;
}

}  // namespace

absl::StatusOr<EditableMap> MoveTo(const EditableMap& map, const Pose3& T_new_map,
                                   const std::optional<GeodeticAnchor>& anchor) {
  EditableMap moved = map;
  const Eigen::Vector3d origin_m = T_new_map * map.Origin_m();
  if (origin_m.cwiseAbs().maxCoeff() > kMaxOrigin_m) {
    return absl::FailedPreconditionError(
        absl::StrFormat("the map would begin at (%g, %g, %g) m; each must lie within %g m",
                        origin_m.x(), origin_m.y(), origin_m.z(), kMaxOrigin_m));
  }
  moved.info.local_origin_m = {origin_m.x(), origin_m.y(), origin_m.z()};
  for (EditableKeyframe& keyframe : moved.keyframes) {
    Pose3 pose = PoseOf(keyframe.record);
    pose.translation_m = T_new_map.rotation * pose.translation_m;
    pose.rotation = (T_new_map.rotation * pose.rotation).normalized();
    keyframe.record.translation_local_m = {pose.translation_m.x(), pose.translation_m.y(),
                                           pose.translation_m.z()};
    keyframe.record.rotation_wxyz = {pose.rotation.w(), pose.rotation.x(), pose.rotation.y(),
                                     pose.rotation.z()};
  }
  SetAnchor(anchor, moved.info);
  return moved;
}

absl::StatusOr<ControlFit> FitAnchor(std::span<const ControlPoint> points) {
  if (points.size() < 2) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "there are %d control points; two at least say where a map lies", points.size()));
  }
  if (Spread_m(points) < kMinSpread_m) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "the control points lie within %g m; they say nothing of the heading", kMinSpread_m));
  }
  ControlFit fit{.anchor = FitOnce(points)};
  for (const ControlPoint& point : points) {
    fit.residual_m.push_back(Distance_m(fit.anchor, point));
  }
  for (std::size_t i = 0; points.size() > 2 && i < points.size(); ++i) {
    std::vector<ControlPoint> others(points.begin(), points.end());
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    fit.left_out_m.push_back(Distance_m(FitOnce(others), points[i]));
  }
  return fit;
}

}  // namespace dcloc
