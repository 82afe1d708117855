#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "core/geometry/pose.h"
#include "core/map/radar_map.h"
#include "core/radar/ego_velocity.h"

namespace dcloc {

/// Keyframes that follow one another along the mapping drive: [begin, end).
struct Stretch {
  std::size_t begin = 0;
  std::size_t end = 0;
};

/// The stretches of a map. A gap, or a turn on the spot, ends one; each has two keyframes at least.
std::vector<Stretch> StretchesOf(const RadarMap& map);

/// A vehicle on its way.
struct PathPoint {
  Pose3 T_map_vehicle;
  EgoVelocity velocity;              ///< vehicle frame
  std::size_t nearest_keyframe = 0;  ///< in time
};

/// The way through a stretch: a level vehicle passes through the positions and headings of all
/// keyframes, without a leap of its velocity (cubic Hermite). It slows down in bends. It comes
/// straight from some way before the first one.
class KeyframePath {
 public:
  /// The stretch is one of `StretchesOf(map)`.
  KeyframePath(const RadarMap& map, const Stretch& stretch, double speed_mps, double lead_m = 0.0);

  /// When it passes the first keyframe.
  double lead_s() const { return knots_[first_knot_].time_s; }
  double duration_s() const { return knots_.back().time_s; }

  /// After `time_s`, in [0, duration_s()].
  PathPoint At(double time_s) const;

 private:
  /// A keyframe: x, y, z and yaw, which does not leap by a whole turn.
  struct Knot {
    double time_s = 0.0;
    Eigen::Vector4d value = Eigen::Vector4d::Zero();
    Eigen::Vector4d rate = Eigen::Vector4d::Zero();
  };

  void Add(const Eigen::Vector3d& position_m, double yaw_rad, double speed_mps);

  std::size_t first_keyframe_;
  std::size_t first_knot_;  ///< that is a keyframe
  std::vector<Knot> knots_;
};

}  // namespace dcloc
