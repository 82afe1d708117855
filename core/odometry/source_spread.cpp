// What hypotheses say beside one another: which of them are implausible, and by how much they
// differ in how the vehicle moves, from what was used and among themselves.
#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/odometry/source_monitor.h"

namespace dcloc {

double SourceMonitor::confidence() const {
  double sum = 0.0;
  for (const Hypothesis& hypothesis : hypotheses_) sum += std::exp(hypothesis.log_weight);
  return 1.0 / sum;
}

void SourceMonitor::DoubtFastReverse() {
  for (Hypothesis& hypothesis : hypotheses_) {
    if (hypothesis.speed.value >= -options_.max_reverse_speed_mps) continue;
    hypothesis.log_weight += std::log(options_.fast_reverse_probability);
  }
}

// Wheels that stand, as those that slip or a bus that is dead, while all that is seen moves: no
// scale of range rates makes motion of none, and no mover fills all directions.
void SourceMonitor::DoubtStanding(const OdometryReadings& readings) {
  const bool sees_only_motion =
      readings.moving_direction_count > options_.narrow_direction_count &&
      readings.standing_direction_count <= options_.max_unseen_direction_count;
  if (!sees_only_motion || !readings.wheel_speed ||
      std::abs(readings.wheel_speed->value) > kStandingSigmas * options_.min_speed_sigma_mps) {
    return;
  }
  for (Hypothesis& hypothesis : hypotheses_) {
    if (Contains(hypothesis.sound, OdometrySource::kDoppler)) continue;
    hypothesis.log_weight -= options_.unseen_standing_log_likelihood;
  }
}

bool SourceMonitor::IsRuledOut(OdometrySource source) const {
  return std::ranges::all_of(hypotheses_, [&](const Hypothesis& hypothesis) {
    return !Contains(hypothesis.sound, source) ||
           hypothesis.log_weight < std::log(options_.min_probability_ratio);
  });
}

bool SourceMonitor::IsCertain(OdometrySource source) const {
  return std::ranges::all_of(hypotheses_, [&](const Hypothesis& hypothesis) {
    return Contains(hypothesis.sound, source) ||
           hypothesis.log_weight < std::log(options_.min_probability_ratio);
  });
}

std::optional<ArcMotion> SourceMonitor::OnUsedMotion(double forward_m, double turn_rad) {
  const double unseen_s2 = since_used_s_ * since_used_s_ / 8.0;
  unseen_s4_ += unseen_s2 * unseen_s2;
  travel_.OnUsedMotion({forward_m, turn_rad}, since_used_s_);
  if (scale_reference_) scale_reference_->unseen_s4 += unseen_s2 * unseen_s2;
  for (Hypothesis& hypothesis : hypotheses_) {
    const ArcMotion own = hypothesis.MotionIn(since_used_s_);
    const ArcMotion beyond{own.forward_m - forward_m, own.turn_rad - turn_rad};
    hypothesis.unapplied += beyond;
    hypothesis.unseen += beyond;
    hypothesis.since_registered += {forward_m, turn_rad};
    hypothesis.since_reference_m += forward_m;
  }
  if (best().sound == used_) return std::nullopt;
  used_ = best().sound;
  // What the others say is besides what the best one has added now.
  const ArcMotion unapplied = best().unapplied;
  for (Hypothesis& hypothesis : hypotheses_) {
    hypothesis.unapplied -= unapplied;
    hypothesis.unseen -= unapplied;
    hypothesis.since_registered += unapplied;
    hypothesis.since_reference_m += unapplied.forward_m;
  }
  travel_.OnCorrection(unapplied);
  return unapplied;
}

ScalarEstimate SourceMonitor::Mixed(ScalarEstimate Hypothesis::*of) const {
  const ScalarEstimate& chosen = best().*of;
  double variance = 0.0;
  double sum = 0.0;
  for (const Hypothesis& hypothesis : hypotheses_) {
    if (hypothesis.log_weight < -options_.spread_log_ratio) continue;
    const double weight = std::exp(hypothesis.log_weight);
    variance += weight * std::pow((hypothesis.*of).value - chosen.value, 2);
    sum += weight;
  }
  return {chosen.value, chosen.variance + variance / sum};
}

bool SourceMonitor::MeasuresSpeed(const Hypothesis& hypothesis) const {
  const auto is_recent = [this](const std::optional<Stamp>& reported) {
    return reported && *compared_ - *reported <= options_.silent_after;
  };
  return (Contains(hypothesis.sound, OdometrySource::kWheelSpeed) &&
          is_recent(last_reported_.wheel_speed)) ||
         (Contains(hypothesis.sound, OdometrySource::kDoppler) &&
          is_recent(last_reported_.doppler_speed));
}

bool SourceMonitor::MeasuresYawRate(const Hypothesis& hypothesis) const {
  const auto is_recent = [this](const std::optional<Stamp>& reported) {
    return reported && *compared_ - *reported <= options_.silent_after;
  };
  return (Contains(hypothesis.sound, OdometrySource::kYawRate) &&
          is_recent(last_reported_.yaw_rate)) ||
         (Contains(hypothesis.sound, OdometrySource::kDoppler) &&
          is_recent(last_reported_.doppler_yaw_rate));
}

// METHOD eq 49. Hypotheses count whose sound sources have reported. All motions are compared with
// that of the best one, as what it misses itself comes of how motions are summed up.
SourceMonitor::Spread SourceMonitor::CurrentSpread() const {
  const double least_log_weight = std::log(options_.min_probability_ratio);
  Spread spread;
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
        spread.speed_variance += weight * std::pow(beyond_gate_mps / static_gate_sigmas_, 2);
      }
      const double unapplied_m = hypothesis.unapplied.forward_m - best().unapplied.forward_m;
      spread.along_track_variance_m2 += weight * std::pow(unapplied_m, 2);
      spread.along_track_bound_m = std::max(spread.along_track_bound_m, std::abs(unapplied_m));
    }
    if (MeasuresYawRate(hypothesis)) {
      yaw_rate_sum += weight;
      spread.yaw_rate_variance +=
          weight * std::pow(hypothesis.yaw_rate.value - best().yaw_rate.value, 2);
      const double unapplied_rad = hypothesis.unapplied.turn_rad - best().unapplied.turn_rad;
      spread.turn_variance_rad2 += weight * std::pow(unapplied_rad, 2);
      spread.turn_bound_rad = std::max(spread.turn_bound_rad, std::abs(unapplied_rad));
    }
  }
  if (speed_sum > 0.0) {
    spread.along_track_variance_m2 /= speed_sum;
  }
  if (yaw_rate_sum > 0.0) {
    spread.yaw_rate_variance /= yaw_rate_sum;
    spread.turn_variance_rad2 /= yaw_rate_sum;
  }
  return spread;
}

}  // namespace dcloc
