// By how much the sources that may be sound disagree on how the vehicle moves.
#include <algorithm>
#include <cmath>

#include "core/odometry/source_monitor.h"

namespace dcloc {
namespace {

bool IsIn(const OdometrySources& sound, OdometrySource source) {
  return sound[static_cast<std::size_t>(source)];
}

// A source that is silent says nothing, be it sound or not.
bool SaySpeed(const OdometrySources& sound, const OdometryReadings& readings) {
  return (IsIn(sound, OdometrySource::kWheelSpeed) && readings.wheel_speed) ||
         (IsIn(sound, OdometrySource::kDoppler) && readings.doppler_speed);
}
bool SayYawRate(const OdometrySources& sound, const OdometryReadings& readings) {
  return (IsIn(sound, OdometrySource::kYawRate) && readings.yaw_rate) ||
         (IsIn(sound, OdometrySource::kDoppler) && readings.doppler_yaw_rate);
}

}  // namespace

// METHOD eq 49. A hypothesis of which no sound source speaks says nothing. What even the best one
// misses is how motion was summed up, and no doubt.
SourceMonitor::Doubt SourceMonitor::CurrentDoubt() const {
  const double least_log_weight = std::log(options_.doubt_probability);
  Doubt doubt;
  double speed_sum = 0.0;
  double yaw_rate_sum = 0.0;
  for (const Hypothesis& hypothesis : hypotheses_) {
    if (hypothesis.log_weight < least_log_weight) continue;
    const double weight = std::exp(hypothesis.log_weight);
    if (SaySpeed(hypothesis.sound, before_)) {
      speed_sum += weight;
      doubt.speed_variance += weight * std::pow(hypothesis.speed.value - best().speed.value, 2);
      const double missed_m = hypothesis.missed.forward_m - best().missed.forward_m;
      doubt.way_variance_m2 += weight * std::pow(missed_m, 2);
      doubt.way_bound_m = std::max(doubt.way_bound_m, std::abs(missed_m));
    }
    if (SayYawRate(hypothesis.sound, before_)) {
      yaw_rate_sum += weight;
      doubt.yaw_rate_variance +=
          weight * std::pow(hypothesis.yaw_rate.value - best().yaw_rate.value, 2);
      doubt.turn_variance_rad2 +=
          weight * std::pow(hypothesis.missed.turn_rad - best().missed.turn_rad, 2);
    }
  }
  if (speed_sum > 0.0) {
    doubt.speed_variance /= speed_sum;
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
        !SaySpeed(hypothesis.sound, before_) ||
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

// METHOD eq 50. Of each hypothesis that speaks, the nearer of the two places is its own. The others
// belong to neither.
void SourceMonitor::OnFits(const MissedMotion& rival, double fit, double rival_fit) {
  fits_compared_ = newest_;
  for (Hypothesis& hypothesis : hypotheses_) {
    const double missed_m = hypothesis.missed.forward_m - best().missed.forward_m;
    const bool is_rivals = std::abs(missed_m - rival.forward_m) < std::abs(missed_m);
    const double own_fit = !SaySpeed(hypothesis.sound, before_) ? 0.5 * (fit + rival_fit)
                           : is_rivals                          ? rival_fit
                                                                : fit;
    hypothesis.log_weight += options_.log_likelihood_per_fit * own_fit;
  }
  Normalize();
}

}  // namespace dcloc
