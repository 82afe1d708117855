#pragma once

#include <optional>

#include "core/odometry/odometry_sources.h"

namespace dcloc {

/// How far each source says that the vehicle has moved since a moment, whether it was believed or
/// not.
class SourceTravel {
 public:
  /// Forgets what was before.
  void Begin() {
    for (Signal* signal : {&wheel_speed_, &yaw_rate_, &doppler_speed_, &doppler_yaw_rate_}) {
      signal->sum = 0.0;
    }
    used_ = {};
  }

  /// Sources that are silent go on saying what they said last.
  void OnReadings(const OdometryReadings& readings) {
    wheel_speed_.Take(readings.wheel_speed);
    yaw_rate_.Take(readings.yaw_rate);
    doppler_speed_.Take(readings.doppler_speed);
    doppler_yaw_rate_.Take(readings.doppler_yaw_rate);
  }

  /// The pose used `motion` in the `duration_s` before the last readings.
  void OnUsedMotion(const ArcMotion& motion, double duration_s) {
    for (Signal* signal : {&wheel_speed_, &yaw_rate_, &doppler_speed_, &doppler_yaw_rate_}) {
      signal->Integrate(duration_s);
    }
    used_ += motion;
  }
  /// And this one besides.
  void OnCorrection(const ArcMotion& motion) { used_ += motion; }

  /// The motion by `sources`, beyond the one that was used; where they say nothing, it is that one.
  ArcMotion BeyondUsed(const OdometrySources& sources) const {
    const auto beyond = [&](const Signal& vehicles, OdometrySource source, const Signal& dopplers,
                            double used) {
      if (Contains(sources, source) && vehicles.now) return vehicles.sum - used;
      if (Contains(sources, OdometrySource::kDoppler) && dopplers.now) return dopplers.sum - used;
      return 0.0;
    };
    return {beyond(wheel_speed_, OdometrySource::kWheelSpeed, doppler_speed_, used_.forward_m),
            beyond(yaw_rate_, OdometrySource::kYawRate, doppler_yaw_rate_, used_.turn_rad)};
  }

 private:
  // A rate, and its integral by trapezoids.
  struct Signal {
    std::optional<double> before;
    std::optional<double> now;
    double sum = 0.0;

    void Take(const std::optional<ScalarEstimate>& reading) {
      if (reading) now = reading->value;
    }
    void Integrate(double duration_s) {
      if (now) sum += 0.5 * (before.value_or(*now) + *now) * duration_s;
      before = now;
    }
  };

  Signal wheel_speed_;
  Signal yaw_rate_;
  Signal doppler_speed_;
  Signal doppler_yaw_rate_;
  ArcMotion used_;
};

}  // namespace dcloc
