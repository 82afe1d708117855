#pragma once

#include <optional>

#include "core/radar/stamp.h"

namespace dcloc {

/// Learns whether the vehicle counts its yaw rate in the other direction. Doppler's yaw rate is
/// regressed on the reported one and on the speed: by a mount that is off, Doppler turns with the
/// speed, by a wrong sign against the reported turn. So one radar tells the two apart as soon as a
/// curve begins (METHOD section 15).
class YawRateSign {
 public:
  /// What the vehicle reports at `stamp`, by the sign that is supposed, and what Doppler says that
  /// is seen in many directions. Returns whether the sign is now supposed to be the other one.
  bool OnYawRates(Stamp stamp, double speed_mps, double reported_radps, double doppler_radps);

  /// Whether reported yaw rates are to be taken with the other sign.
  bool is_reversed() const { return is_reversed_; }

  /// By how much the vehicle was taken to turn while the sign was found, about [rad].
  double turn_rad() const { return turn_rad_; }

 private:
  // Of the regression d = a w + b v; older moments count less.
  struct Sums {
    double ww = 0.0, wv = 0.0, vv = 0.0, dw = 0.0, dv = 0.0, dd = 0.0, count = 0.0;
  };
  bool IsOpposite() const;

  Sums sums_;
  std::optional<Stamp> last_;
  bool is_reversed_ = false;
  double turn_rad_ = 0.0;
};

}  // namespace dcloc
