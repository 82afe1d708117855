// What the map says of the sources: how registrations have moved, and where scans fit.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>

#include "core/odometry/source_monitor.h"
#include "core/radar/stamp.h"

namespace dcloc {
namespace {

constexpr auto kWheels = static_cast<std::size_t>(OdometrySource::kWheelSpeed);
constexpr auto kRangeRates = static_cast<std::size_t>(OdometrySource::kDoppler);

double Squared(double value) { return value * value; }

}  // namespace

// Each hypothesis with Doppler has a twin without it, which has moved alike until now.
void SourceMonitor::OnDopplersScaleChange(double forward_m) {
  const double log_probability = std::log(options_.doppler_scale_change_probability);
  for (const Hypothesis& with : hypotheses_) {
    if (!with.sound[kRangeRates] || !with.sound[kWheels]) continue;
    OdometrySources sound = with.sound;
    sound.reset(kRangeRates);
    Hypothesis& without = hypotheses_[sound.to_ulong()];
    if (without.log_weight >= with.log_weight + log_probability) continue;
    without = with;
    without.sound = sound;
    without.log_weight += log_probability;
  }
  for (Hypothesis& hypothesis : hypotheses_) {
    hypothesis.since_registered.forward_m += forward_m;
    hypothesis.since_reference_m += forward_m;
    if (hypothesis.sound[kRangeRates]) continue;
    hypothesis.unapplied.forward_m -= forward_m;
    hypothesis.unseen.forward_m -= forward_m;
  }
}

// The points that are registered were joined by the motion that was used. So the registration is
// where the middle of them lies right: of what a hypothesis moves otherwise it sees what is older
// than they are on average.
void SourceMonitor::SeeMotion(const RegistrationEvidence& evidence) {
  const double age_s = SecondsOf(evidence.submap_age);
  const bool has_lag = newest_registered_ && age_s > 0.0;
  const double seen =
      has_lag ? 1.0 - std::exp(-SecondsOf(*newest_ - *newest_registered_) / age_s) : 1.0;
  newest_registered_ = newest_;
  for (Hypothesis& hypothesis : hypotheses_) {
    const ArcMotion now_seen{
        evidence.observes_along_track ? seen * hypothesis.unseen.forward_m : 0.0,
        seen * hypothesis.unseen.turn_rad};
    hypothesis.unseen -= now_seen;
    hypothesis.since_registered += now_seen;
    hypothesis.since_reference_m += now_seen.forward_m;
  }
}

void SourceMonitor::OnRegistration(const Pose2& T_map_vehicle,
                                   const RegistrationEvidence& evidence) {
  if (!newest_) return;
  SeeMotion(evidence);
  if (evidence.is_accepted) {
    for (Hypothesis& hypothesis : hypotheses_) {
      const bool is_disputed = hypothesis.log_weight > -options_.disputed_log_ratio;
      hypothesis.unapplied.turn_rad = is_disputed ? hypothesis.unseen.turn_rad : 0.0;
      if (!evidence.observes_along_track) continue;
      hypothesis.unapplied.forward_m = is_disputed ? hypothesis.unseen.forward_m : 0.0;
    }
    OnSourcesFit(*newest_);
    trial_count_ = 1;
  }
  CompareScales(T_map_vehicle, evidence);
  if (registered_) {
    const std::chrono::nanoseconds interval = *newest_ - registered_->stamp;
    if (interval < options_.min_registered_interval) return;
    if (interval <= options_.max_registered_interval) {
      CompareWithRegistration(T_map_vehicle, evidence);
    }
  }
  registered_ = {*newest_, T_map_vehicle, evidence.observes_along_track};
  unseen_s4_ = 0.0;
  for (Hypothesis& hypothesis : hypotheses_) hypothesis.since_registered = {};
}

// While Doppler's word of the wheels' scale is open: by few per cent hypotheses differ little
// between neighbouring registrations, and more with one further back. Of several with that one, the
// last one counts for all of them.
void SourceMonitor::CompareScales(const Pose2& T_map_vehicle,
                                  const RegistrationEvidence& evidence) {
  if (!ScaleIsOpen()) scale_reference_.reset();
  if (!ScaleIsOpen() || !evidence.observes_along_track) return;
  if (scale_reference_) {
    const std::chrono::nanoseconds interval = *newest_ - scale_reference_->stamp;
    if (interval < options_.min_registered_interval) return;
    if (interval <= options_.max_registered_interval) {
      CompareWithReference(T_map_vehicle);
      if (!HasDecided()) return;
    }
  }
  scale_reference_ = {.stamp = *newest_, .T_map_vehicle = T_map_vehicle, .unseen_s4 = 0.0};
  for (Hypothesis& hypothesis : hypotheses_) {
    hypothesis.since_reference_m = 0.0;
    hypothesis.log_evidence = 0.0;
  }
}

void SourceMonitor::CompareWithReference(const Pose2& T_map_vehicle) {
  const double duration_s = SecondsOf(*newest_ - scale_reference_->stamp);
  const double moved_m = Log(scale_reference_->T_map_vehicle.Inverse() * T_map_vehicle)(0);
  const double range_m = options_.speed_range_mps * duration_s;
  for (Hypothesis& hypothesis : hypotheses_) {
    // What a filter's speed errs by lasts for about a second.
    const double variance_m2 =
        2.0 * Squared(options_.registered_sigma_m) +
        hypothesis.speed.variance * duration_s * std::min(1.0, duration_s) +
        Squared(options_.acceleration_sigma_mps2) * scale_reference_->unseen_s4;
    const double density = std::exp(LogNormal(moved_m - hypothesis.since_reference_m, variance_m2));
    const double log_evidence = std::log((1.0 - options_.false_registration_fraction) * density +
                                         options_.false_registration_fraction / range_m);
    hypothesis.log_weight += log_evidence - std::exchange(hypothesis.log_evidence, log_evidence);
  }
  Normalize();
}

// Whether the registrations of late tell hypotheses apart that are not improbable.
bool SourceMonitor::HasDecided() const {
  double least = std::numeric_limits<double>::infinity();
  double greatest = -least;
  for (const Hypothesis& hypothesis : hypotheses_) {
    if (hypothesis.log_weight < std::log(options_.min_probability_ratio)) continue;
    least = std::min(least, hypothesis.log_evidence);
    greatest = std::max(greatest, hypothesis.log_evidence);
  }
  return greatest - least > options_.decisive_log_ratio;
}

// METHOD eq 44: the motion between two registrations against each hypothesis' own; along-track as
// far as both observe that.
void SourceMonitor::CompareWithRegistration(const Pose2& T_map_vehicle,
                                            const RegistrationEvidence& evidence) {
  const double duration_s = SecondsOf(*newest_ - registered_->stamp);
  const Tangent<2> moved = Log(registered_->T_map_vehicle.Inverse() * T_map_vehicle);
  const bool compares_along_track =
      registered_->observes_along_track && evidence.observes_along_track && !ScaleIsOpen();
  const double range_m = options_.speed_range_mps * duration_s;
  const double range_rad = options_.yaw_rate_range_radps * duration_s;
  for (Hypothesis& hypothesis : hypotheses_) {
    const double along_track_variance_m2 = 2.0 * Squared(options_.registered_sigma_m) +
                                           hypothesis.speed.variance * Squared(duration_s) +
                                           Squared(options_.acceleration_sigma_mps2) * unseen_s4_;
    const double turn_variance_rad2 = 2.0 * Squared(options_.registered_sigma_rad) +
                                      hypothesis.yaw_rate.variance * Squared(duration_s) +
                                      Squared(options_.yaw_acceleration_sigma_radps2) * unseen_s4_;
    const double along_track_m = moved(0) - hypothesis.since_registered.forward_m;
    const double turn_rad = WrapAngle(moved(2) - hypothesis.since_registered.turn_rad);
    const double along_track_density =
        compares_along_track ? std::exp(LogNormal(along_track_m, along_track_variance_m2))
                             : 1.0 / range_m;
    const double density = along_track_density * std::exp(LogNormal(turn_rad, turn_variance_rad2));
    const double anything = 1.0 / (range_m * range_rad);
    hypothesis.log_weight += std::log((1.0 - options_.false_registration_fraction) * density +
                                      options_.false_registration_fraction * anything);
  }
  Normalize();
}

ArcMotion SourceMonitor::BesideBest(const Hypothesis& hypothesis) const {
  ArcMotion beside = hypothesis.unapplied;
  return beside -= best().unapplied;
}

// How far two places are apart: from 1 on scans tell them apart.
double SourceMonitor::Apart(const ArcMotion& a, const ArcMotion& b) const {
  return std::hypot((a.forward_m - b.forward_m) / options_.min_alternative_distance_m,
                    (a.turn_rad - b.turn_rad) / options_.min_alternative_turn_rad);
}

// Whether the sources of a hypothesis say if the vehicle has moved by `difference` beyond the
// motion of the best one.
bool SourceMonitor::MeasuresDifference(const Hypothesis& hypothesis,
                                       const ArcMotion& difference) const {
  const bool moves = std::abs(difference.forward_m) >= options_.min_alternative_distance_m;
  const bool turns = std::abs(difference.turn_rad) >= options_.min_alternative_turn_rad;
  return (!moves || MeasuresSpeed(hypothesis)) && (!turns || MeasuresYawRate(hypothesis));
}

std::optional<ArcMotion> SourceMonitor::Alternative(std::size_t radar_index) const {
  const bool was_compared =
      radar_index < fits_compared_.size() && fits_compared_[radar_index].has_value();
  if (was_compared && *newest_ - *fits_compared_[radar_index] < options_.interval) {
    return std::nullopt;
  }
  const Hypothesis* alternative = nullptr;
  for (const Hypothesis& hypothesis : hypotheses_) {
    if (&hypothesis == &best() ||
        hypothesis.log_weight < std::log(options_.min_probability_ratio) ||
        !MeasuresDifference(hypothesis, BesideBest(hypothesis)) ||
        Apart(BesideBest(hypothesis), {}) < 1.0) {
      continue;
    }
    if (alternative == nullptr || hypothesis.log_weight > alternative->log_weight)
      alternative = &hypothesis;
  }
  if (alternative == nullptr) return std::nullopt;
  return BesideBest(*alternative);
}

// METHOD eq 50. Each hypothesis is as probable as the nearer of the two places fits. One whose
// sources are silent has no place of its own: it counts with the mean.
void SourceMonitor::OnFits(std::size_t radar_index, const ArcMotion& alternative, double fit,
                           double alternative_fit) {
  fits_compared_.resize(std::max(fits_compared_.size(), radar_index + 1));
  fits_compared_[radar_index] = newest_;
  for (Hypothesis& hypothesis : hypotheses_) {
    const ArcMotion own = BesideBest(hypothesis);
    const double own_fit = !MeasuresDifference(hypothesis, alternative)
                               ? 0.5 * (fit + alternative_fit)
                           : Apart(own, alternative) < Apart(own, {}) ? alternative_fit
                                                                      : fit;
    hypothesis.log_weight += options_.log_likelihood_per_fit * own_fit;
  }
  Normalize();
}

}  // namespace dcloc
