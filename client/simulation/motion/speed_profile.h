#pragma once

#include <vector>

#include "client/simulation/world/path.h"
#include "client/simulation/world/random.h"

namespace dcloc::simulation {

struct SpeedProfileOptions {
  double begin_m = 0.0;  ///< along the path
  double end_m = 0.0;
  double mean_speed_mps = 10.0;  ///< over the whole drive, halts included, where bends allow it
  double max_lateral_acceleration_mps2 = 3.0;
  double max_acceleration_mps2 = 2.5;
  double max_braking_mps2 = 3.0;
  std::vector<double> stops_m;  ///< where the vehicle halts for a few seconds, ascending
};

/// How a vehicle moves along a path: position s(t), its speed (continuous and piecewise linear) and
/// so acceleration, exactly consistent with one another at every time.
class SpeedProfile {
 public:
  struct State {
    double s_m = 0.0;
    double speed_mps = 0.0;
  };

  /// Constant speed, for ever.
  static SpeedProfile Constant(double begin_m, double speed_mps);

  State At(double t_s) const;

  /// Time at which the end is reached.
  double duration_s() const { return duration_s_; }

 private:
  friend SpeedProfile MakeSpeedProfile(const Path&, const SpeedProfileOptions&, Random&);

  std::vector<double> s_m_;        // at equal time steps
  std::vector<double> speed_mps_;  // likewise
  double duration_s_ = 0.0;
};

/// A driver's speeds: slower in bends, unsteady by some 10 %, bounded accelerations. If bends and
/// halts make the mean impossible, the actual mean is lower.
SpeedProfile MakeSpeedProfile(const Path& path, const SpeedProfileOptions& options, Random& random);

}  // namespace dcloc::simulation
