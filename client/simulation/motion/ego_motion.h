#pragma once

#include "client/simulation/motion/speed_profile.h"
#include "client/simulation/world/path.h"
#include "client/simulation/world/random.h"
#include "core/geometry/pose.h"

namespace dcloc::simulation {

/// A vehicle's exact motion. The frame is its rear axle's middle on the ground, x forward, so that
/// without side slip the velocity lies along x.
struct MotionState {
  Pose2 T_map_vehicle;
  double speed_mps = 0.0;  ///< along x
  double yaw_rate_radps = 0.0;
};

/// How a driver keeps the lane: `offset_m` left of the path plus slow weaving.
class LaneKeeping {
 public:
  /// Steady at `offset_m`.
  explicit LaneKeeping(double offset_m) : offset_m_(offset_m) {}
  /// With weaving of some 0.15 m over 60 to 150 m.
  LaneKeeping(double offset_m, Random& random);

  /// The offset and its first two derivatives by arc length.
  struct Offset {
    double value_m, slope, bend_per_m;
  };
  Offset At(double s_m) const;

 private:
  struct Wave {
    double amplitude_m = 0.0, wave_number_per_m = 0.0, phase_rad = 0.0;
  };
  double offset_m_;
  Wave waves_[2];
};

/// A drive along a path without side slip: poses, speed and yaw rate are exact derivatives of one
/// another. `path` must outlive it.
class EgoMotion {
 public:
  EgoMotion(const Path& path, SpeedProfile profile, LaneKeeping lane)
      : path_(path), profile_(std::move(profile)), lane_(lane) {}

  MotionState At(double t_s) const;
  /// Where along the path, and how fast along it.
  SpeedProfile::State PathStateAt(double t_s) const { return profile_.At(t_s); }
  /// The path that it follows.
  const Path& path() const { return path_; }
  double duration_s() const { return profile_.duration_s(); }

 private:
  const Path& path_;
  SpeedProfile profile_;
  LaneKeeping lane_;
};

/// The motion of a vehicle at `s_m` of a path, `lane.value_m` left of it, when s grows by
/// `speed_mps`.
MotionState MotionOnPath(const Path& path, double s_m, double speed_mps,
                         const LaneKeeping::Offset& lane);

}  // namespace dcloc::simulation
