#pragma once

#include <cmath>
#include <numbers>
#include <optional>

#include "core/odometry/scalar_estimate.h"

namespace dcloc {

/// Of a normal deviate with mean 0.
inline double LogNormal(double difference, double variance) {
  return -0.5 * (difference * difference / variance + std::log(2.0 * std::numbers::pi * variance));
}

/// Of a reading, by a state that it would change.
inline double LogDensity(const ScalarEstimate& reading, const ScalarEstimate& state) {
  return LogNormal(reading.value - state.value, state.variance + reading.variance);
}

/// A reading of a state that is sound: its log-density; the state takes it in. One that repeats
/// itself is a single number among those that might be repeated, and has a probability instead.
inline double KalmanUpdate(const ScalarEstimate& reading, bool repeats, ScalarEstimate& state) {
  const double innovation = reading.value - state.value;
  const double spread = state.variance + reading.variance;
  const double gain = state.variance / spread;
  state.value += gain * innovation;
  state.variance *= 1.0 - gain;
  return LogNormal(innovation, spread) - (repeats ? LogNormal(0.0, spread) : 0.0);
}

/// Of a source that has failed: nearly what it said before, or anything.
inline double FailedLogDensity(const ScalarEstimate& reading,
                               const std::optional<ScalarEstimate>& before, double walk_variance,
                               double range, double unchanged_fraction) {
  const double anything = 1.0 / range;
  if (!before) return std::log(anything);
  const double unchanged = std::exp(LogNormal(reading.value - before->value,
                                              reading.variance + before->variance + walk_variance));
  return std::log(unchanged_fraction * unchanged + (1.0 - unchanged_fraction) * anything);
}

}  // namespace dcloc
