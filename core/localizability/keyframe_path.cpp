#include "core/localizability/keyframe_path.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dcloc {
namespace {

constexpr double kMaxGap_m = 30.0;
constexpr double kMaxYawRate_radps = 0.4;
constexpr double kMaxTurn_rad = std::numbers::pi / 2.0;

bool Follows(const Pose3& T_map_from, const Pose3& T_map_to) {
  const Pose3 T_from_to = T_map_from.Inverse() * T_map_to;
  const double distance_m = T_from_to.translation_m.norm();
  return distance_m > 0.1 && distance_m <= kMaxGap_m && RotationAngle(T_from_to) <= kMaxTurn_rad;
}

}  // namespace

std::vector<Stretch> StretchesOf(const RadarMap& map) {
  std::vector<Stretch> stretches;
  const std::size_t count = map.info().keyframe_count;
  for (std::size_t begin = 0; begin < count;) {
    std::size_t end = begin + 1;
    while (end < count &&
           Follows(map.keyframe(end - 1).T_map_keyframe, map.keyframe(end).T_map_keyframe)) {
      ++end;
    }
    if (end - begin >= 2) stretches.push_back({begin, end});
    begin = end;
  }
  return stretches;
}

KeyframePath::KeyframePath(const RadarMap& map, const Stretch& stretch, double speed_mps,
                           double lead_m)
    : first_keyframe_(stretch.begin), first_knot_(lead_m > 0.0 ? 1 : 0) {
  if (lead_m > 0.0) {
    const Pose3 T_map_first = map.keyframe(stretch.begin).T_map_keyframe;
    Add(T_map_first * Eigen::Vector3d(-lead_m, 0.0, 0.0), Yaw(T_map_first.rotation), speed_mps);
  }
  for (std::size_t i = stretch.begin; i < stretch.end; ++i) {
    const Pose3 T_map_keyframe = map.keyframe(i).T_map_keyframe;
    Add(T_map_keyframe.translation_m, Yaw(T_map_keyframe.rotation), speed_mps);
  }
  for (std::size_t i = 0; i < knots_.size(); ++i) {
    const Knot& before = knots_[i == 0 ? 0 : i - 1];
    const Knot& after = knots_[std::min(i + 1, knots_.size() - 1)];
    knots_[i].rate = (after.value - before.value) / (after.time_s - before.time_s);
  }
}

void KeyframePath::Add(const Eigen::Vector3d& position_m, double yaw_rad, double speed_mps) {
  Knot knot;
  knot.value << position_m, yaw_rad;
  if (!knots_.empty()) {
    const Knot& last = knots_.back();
    const double turn_rad = WrapAngle(yaw_rad - last.value(3));
    const double way_m = (knot.value - last.value).head<3>().norm();
    knot.value(3) = last.value(3) + turn_rad;
    knot.time_s = last.time_s + std::max(way_m / speed_mps, std::abs(turn_rad) / kMaxYawRate_radps);
  }
  knots_.push_back(knot);
}

PathPoint KeyframePath::At(double time_s) const {
  const auto next =
      std::upper_bound(knots_.begin() + 1, knots_.end() - 1, time_s,
                       [](double time, const Knot& knot) { return time < knot.time_s; });
  const Knot& a = *(next - 1);
  const Knot& b = *next;
  const double step_s = b.time_s - a.time_s;
  const double u = (time_s - a.time_s) / step_s;
  const Eigen::Vector4d way = b.value - a.value;
  // Of the cubic Hermite polynomial, and its derivative.
  const Eigen::Vector4d value = a.value + u * u * (3.0 - 2.0 * u) * way +
                                step_s * u * (1.0 - u) * ((1.0 - u) * a.rate - u * b.rate);
  const Eigen::Vector4d rate = 6.0 * u * (1.0 - u) * way / step_s +
                               (1.0 - u) * (1.0 - 3.0 * u) * a.rate + u * (3.0 * u - 2.0) * b.rate;
  PathPoint point;
  point.T_map_vehicle = Embed({value.head<2>(), value(3)});
  point.T_map_vehicle.translation_m.z() = value(2);
  point.velocity.linear_mps = point.T_map_vehicle.rotation.conjugate() * rate.head<3>();
  point.velocity.angular_radps.z() = rate(3);
  const std::size_t knot = static_cast<std::size_t>(next - knots_.begin()) - (u < 0.5 ? 1 : 0);
  point.nearest_keyframe = first_keyframe_ + (knot > first_knot_ ? knot - first_knot_ : 0);
  return point;
}

}  // namespace dcloc
