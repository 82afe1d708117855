// By how much the hypotheses that are probable differ in how the vehicle moves.
#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/odometry/source_monitor.h"

namespace dcloc {
namespace {

bool IsIn(const OdometrySources& sound, OdometrySource source) {
  return sound[static_cast<std::size_t>(source)];
}

}  // namespace

bool SourceMonitor::MeasuresSpeed(const Hypothesis& hypothesis) const {
  const auto is_recent = [this](const std::optional<Stamp>& reported) {
    return reported && *compared_ - *reported <= options_.silent_after;
  };
  return (IsIn(hypothesis.sound, OdometrySource::kWheelSpeed) &&
          is_recent(last_reported_.wheel_speed)) ||
         (IsIn(hypothesis.sound, OdometrySource::kDoppler) &&
          is_recent(last_reported_.doppler_speed));
}

bool SourceMonitor::MeasuresYawRate(const Hypothesis& hypothesis) const {
  const auto is_recent = [this](const std::optional<Stamp>& reported) {
    return reported && *compared_ - *reported <= options_.silent_after;
  };
  return (IsIn(hypothesis.sound, OdometrySource::kYawRate) && is_recent(last_reported_.yaw_rate)) ||
         (IsIn(hypothesis.sound, OdometrySource::kDoppler) &&
          is_recent(last_reported_.doppler_yaw_rate));
}

// METHOD eq 49. Hypotheses count whose sound sources have reported. All ways are compared with that
// of the best one, as what it misses itself comes of how motions are summed up.
SourceMonitor::Doubt SourceMonitor::CurrentDoubt() const {
  const double least_log_weight = std::log(options_.doubt_probability);
  Doubt doubt;
  double speed_sum = 0.0;
  double yaw_rate_sum = 0.0;
  for (const Hypothesis& hypothesis : hypotheses_) {
    if (hypothesis.log_weight < least_log_weight) continue;
    const double weight = std::exp(hypothesis.log_weight);
    if (MeasuresSpeed(hypothesis)) {
      speed_sum += weight;
      const double apart_mps = std::abs(hypothesis.speed.value - best().speed.value);
      const double beyond_gate_mps = std::max(0.0, apart_mps - static_gate_mps_);
      if (static_gate_sigmas_ > 0.0) {  // else deviations do not widen the gate
        doubt.speed_variance += weight * std::pow(beyond_gate_mps / static_gate_sigmas_, 2);
      }
      const double missed_m = hypothesis.missed.forward_m - best().missed.forward_m;
      doubt.way_variance_m2 += weight * std::pow(missed_m, 2);
      doubt.way_bound_m = std::max(doubt.way_bound_m, std::abs(missed_m));
    }
    if (MeasuresYawRate(hypothesis)) {
      yaw_rate_sum += weight;
      doubt.yaw_rate_variance +=
          weight * std::pow(hypothesis.yaw_rate.value - best().yaw_rate.value, 2);
      doubt.turn_variance_rad2 +=
          weight * std::pow(hypothesis.missed.turn_rad - best().missed.turn_rad, 2);
    }
  }
  if (speed_sum > 0.0) {
    doubt.way_variance_m2 /= speed_sum;
  }
  if (yaw_rate_sum > 0.0) {
    doubt.yaw_rate_variance /= yaw_rate_sum;
    doubt.turn_variance_rad2 /= yaw_rate_sum;
  }
  return doubt;
}

std::optional<SourceMonitor::MissedMotion> SourceMonitor::Rival() const {
  if (fits_compared_ && *newest_ - *fits_compared_ < options_.interval) return std::nullopt;
  const Hypothesis* rival = nullptr;
  for (const Hypothesis& hypothesis : hypotheses_) {
    if (&hypothesis == &best() || hypothesis.log_weight < std::log(options_.doubt_probability) ||
        !MeasuresSpeed(hypothesis) ||
        std::abs(hypothesis.missed.forward_m - best().missed.forward_m) <
            options_.min_rival_way_m) {
      continue;
    }
    if (rival == nullptr || hypothesis.log_weight > rival->log_weight) rival = &hypothesis;
  }
  if (rival == nullptr) return std::nullopt;
  return MissedMotion{.forward_m = rival->missed.forward_m - best().missed.forward_m,
                      .turn_rad = rival->missed.turn_rad - best().missed.turn_rad};
}

// METHOD eq 50. Each hypothesis is as probable as the nearer of the two places fits. One whose
// sources are silent has no place of its own: it counts with the mean.
void SourceMonitor::OnFits(const MissedMotion& rival, double fit, double rival_fit) {
  fits_compared_ = newest_;
  for (Hypothesis& hypothesis : hypotheses_) {
    const double missed_m = hypothesis.missed.forward_m - best().missed.forward_m;
    const bool is_rivals = std::abs(missed_m - rival.forward_m) < std::abs(missed_m);
    const double own_fit = !MeasuresSpeed(hypothesis) ? 0.5 * (fit + rival_fit)
                           : is_rivals                ? rival_fit
                                                      : fit;
    hypothesis.log_weight += options_.log_likelihood_per_fit * own_fit;
  }
  Normalize();
}

}  // namespace dcloc
