// How probable it is that sources fail, or recover, within some time.
#include <algorithm>
#include <cmath>

#include "core/odometry/source_monitor.h"

namespace dcloc {

// One mover is seen in few directions: the more there are, the less often Doppler fails.
SourceMonitor::Transitions SourceMonitor::TransitionsIn(double duration_s, int direction_count,
                                                        double min_doppler_failure_rate_hz) const {
  const double further = std::max(0, direction_count - options_.narrow_direction_count);
  const double rarer = std::pow(options_.direction_factor, further);
  return {.wheel_failure = Change(options_.wheel_failure_rate_hz, duration_s),
          .yaw_rate_failure = Change(options_.yaw_rate_failure_rate_hz, duration_s),
          .bus_failure = Change(options_.bus_failure_rate_hz, duration_s),
          .second_bus_failure = Change(options_.second_bus_failure_rate_hz, duration_s),
          .doppler_failure = Change(
              std::max(min_doppler_failure_rate_hz, options_.doppler_failure_rate_hz * rarer),
              duration_s),
          .recovery = Change(options_.recovery_rate_hz, duration_s)};
}

SourceMonitor::Change::Change(double rate_hz, double duration_s)
    : log_stay(-rate_hz * duration_s),
      log_change(std::log(std::max(1e-12, 1.0 - std::exp(-rate_hz * duration_s)))) {}

// Of the sources that fail, recover, or stay as they are.
double SourceMonitor::LogTransition(const OdometrySources& before, const OdometrySources& after,
                                    const Transitions& transitions) {
  using enum OdometrySource;
  const auto log_of = [&](OdometrySource source, const Change& failure, const Change& recovery) {
    const Change& change = Contains(before, source) ? failure : recovery;
    return Contains(before, source) == Contains(after, source) ? change.log_stay
                                                               : change.log_change;
  };
  double log_probability = log_of(kDoppler, transitions.doppler_failure, transitions.recovery);
  const auto both = [](const OdometrySources& sources) {
    return Contains(sources, kWheelSpeed) && Contains(sources, kYawRate);
  };
  const bool both_sound = both(before);
  const bool both_failed = both(~before);
  if (both_sound && both(~after)) {
    return log_probability + transitions.bus_failure.log_change;
  }
  if (both_failed && both(after)) {
    return log_probability + transitions.recovery.log_change;
  }
  // Else the other one has failed already.
  log_probability +=
      log_of(kWheelSpeed, both_sound ? transitions.wheel_failure : transitions.second_bus_failure,
             transitions.recovery);
  log_probability +=
      log_of(kYawRate, both_sound ? transitions.yaw_rate_failure : transitions.second_bus_failure,
             transitions.recovery);
  return log_probability;
}

}  // namespace dcloc
