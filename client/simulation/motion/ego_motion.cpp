#include "client/simulation/motion/ego_motion.h"

#include <cmath>
#include <numbers>

namespace dcloc::simulation {

LaneKeeping::LaneKeeping(double offset_m, Random& random) : offset_m_(offset_m) {
  for (Wave& wave : waves_) {
    wave = {Uniform(random, 0.05, 0.15), 2.0 * std::numbers::pi / Uniform(random, 60.0, 150.0),
            Uniform(random, 0.0, 2.0 * std::numbers::pi)};
  }
}

LaneKeeping::Offset LaneKeeping::At(double s_m) const {
  Offset offset{offset_m_, 0.0, 0.0};
  for (const Wave& wave : waves_) {
    const double k = wave.wave_number_per_m;
    const double angle = k * s_m + wave.phase_rad;
    offset.value_m += wave.amplitude_m * std::sin(angle);
    offset.slope += wave.amplitude_m * k * std::cos(angle);
    offset.bend_per_m -= wave.amplitude_m * k * k * std::sin(angle);
  }
  return offset;
}

MotionState MotionOnPath(const Path& path, double s_m, double speed_mps,
                         const LaneKeeping::Offset& lane) {
  // With p(s) = c(s) + d(s) n(s): p' = (1 - k d) t + d' n, so the heading leads the path's by
  // atan(d' / (1 - k d)).
  const PathPoint point = path.At(s_m);
  const double k = point.curvature_per_m;
  const double scale = 1.0 - k * lane.value_m;
  const double scale_rate = -(point.curvature_rate_per_m2 * lane.value_m + k * lane.slope);
  const double tangent = lane.slope / scale;
  const double tangent_rate = (lane.bend_per_m * scale - lane.slope * scale_rate) / (scale * scale);

  MotionState state;
  state.T_map_vehicle.translation_m = point.position_m + lane.value_m * LeftOf(point.heading_rad);
  state.T_map_vehicle.yaw_rad = WrapAngle(point.heading_rad + std::atan(tangent));
  state.speed_mps = speed_mps * std::hypot(scale, lane.slope);
  state.yaw_rate_radps = speed_mps * (k + tangent_rate / (1.0 + tangent * tangent));
  return state;
}

MotionState EgoMotion::At(double t_s) const {
  const SpeedProfile::State state = profile_.At(t_s);
  return MotionOnPath(path_, state.s_m, state.speed_mps, lane_.At(state.s_m));
}

}  // namespace dcloc::simulation
