#include "core/odometry/source_monitor.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/radar/stamp.h"

namespace dcloc {
namespace {

constexpr auto kWheelSpeed = static_cast<std::size_t>(OdometrySource::kWheelSpeed);
constexpr auto kYawRate = static_cast<std::size_t>(OdometrySource::kYawRate);
constexpr auto kDoppler = static_cast<std::size_t>(OdometrySource::kDoppler);

// A turn that changes by no more deviations is usual.
constexpr double kUsualSigmas = 3.0;

double SquareOf(double value) { return value * value; }

double LogDensity(const ScalarEstimate& reading, const ScalarEstimate& state) {
  return LogNormal(reading.value - state.value, state.variance + reading.variance);
}

// A reading of a state that is sound: its log-density; the state takes it in.
double KalmanUpdate(const ScalarEstimate& reading, ScalarEstimate& state) {
  const double innovation = reading.value - state.value;
  const double spread = state.variance + reading.variance;
  const double gain = state.variance / spread;
  state.value += gain * innovation;
  state.variance *= 1.0 - gain;
  return LogNormal(innovation, spread);
}

// Of a source that has failed: nearly what it said before, or anything.
double FailedLogDensity(const ScalarEstimate& reading, const std::optional<ScalarEstimate>& before,
                        double walk_variance, double range, double unchanged_fraction) {
  const double anything = 1.0 / range;
  if (!before) return std::log(anything);
  const double unchanged = std::exp(LogNormal(reading.value - before->value,
                                              reading.variance + before->variance + walk_variance));
  return std::log(unchanged_fraction * unchanged + (1.0 - unchanged_fraction) * anything);
}

std::optional<ScalarEstimate> Divided(std::optional<ScalarEstimate> reading, double divisor) {
  if (reading) reading->value /= divisor;  // as uncertain, so that as probable
  return reading;
}

ScalarEstimate Floored(const ScalarEstimate& reading, double sigma) {
  return {reading.value, std::max(reading.variance, sigma * sigma)};
}

}  // namespace

std::span<const OptionField<SourceMonitorOptions>> FieldsOf(
    const SourceMonitorOptions& /*options*/) {
  using O = SourceMonitorOptions;
  static constexpr OptionField<O> kFields[] = {
      {"interval_ms", &O::interval, 0, 1e4, "all readings are compared"},
      {"wheel_failure_rate_hz", &O::wheel_failure_rate_hz, 1e-9, 10},
      {"yaw_rate_failure_rate_hz", &O::yaw_rate_failure_rate_hz, 1e-9, 10},
      {"doppler_failure_rate_hz", &O::doppler_failure_rate_hz, 1e-9, 10},
      {"second_bus_failure_rate_hz", &O::second_bus_failure_rate_hz, 1e-9, 10},
      {"narrow_direction_count", &O::narrow_direction_count, 0, 36, "each direction counts"},
      {"direction_factor", &O::direction_factor, 1e-3, 1},
      {"bus_failure_rate_hz", &O::bus_failure_rate_hz, 1e-9, 10},
      {"min_doppler_failure_rate_hz", &O::min_doppler_failure_rate_hz, 1e-12, 10},
      {"knocked_radar_rate_hz", &O::knocked_radar_rate_hz, 1e-12, 10},
      {"doppler_scale_change_probability", &O::doppler_scale_change_probability, 1e-12, 1},
      {"standing_doppler_failure_rate_hz", &O::standing_doppler_failure_rate_hz, 1e-9, 100},
      {"max_reverse_speed_mps", &O::max_reverse_speed_mps, 0.1, 1000},
      {"max_unseen_direction_count", &O::max_unseen_direction_count, 0, 36,
       "one target that stands still is enough"},
      {"unseen_standing_log_likelihood", &O::unseen_standing_log_likelihood, 0, 100,
       "what stands still may be out of sight"},
      {"fast_reverse_probability", &O::fast_reverse_probability, 1e-30, 1},
      {"recovery_rate_hz", &O::recovery_rate_hz, 1e-9, 10},
      {"start_span_ms", &O::start_span, 1, 1e6},
      {"silent_after_ms", &O::silent_after, 1, 1e5},
      {"max_log_ratio", &O::max_log_ratio, 1, 700},
      {"stuck_log_ratio", &O::stuck_log_ratio, 0, 700, "one that is repeated is taken back"},
      {"disputed_log_ratio", &O::disputed_log_ratio, 0, 700, "each accepted registration refutes"},
      {"spread_log_ratio", &O::spread_log_ratio, 0, 700, "no other hypothesis widens the motion"},
      {"min_speed_sigma_mps", &O::min_speed_sigma_mps, 1e-6, 100},
      {"min_speed_sigma_fraction", &O::min_speed_sigma_fraction, 0, 1, "the deviation is constant"},
      {"min_yaw_rate_sigma_radps", &O::min_yaw_rate_sigma_radps, 1e-6, 10},
      {"acceleration_sigma_mps2", &O::acceleration_sigma_mps2, 1e-6, 100},
      {"yaw_acceleration_sigma_radps2", &O::yaw_acceleration_sigma_radps2, 1e-6, 100},
      {"speed_range_mps", &O::speed_range_mps, 1, 1000},
      {"yaw_rate_range_radps", &O::yaw_rate_range_radps, 0.01, 100},
      {"unchanged_fraction", &O::unchanged_fraction, 0, 0.999, "a failed source may say anything"},
      {"unknown_speed_sigma_mps", &O::unknown_speed_sigma_mps, 1e-6, 1000},
      {"silent_yaw_rate_sigma_radps", &O::silent_yaw_rate_sigma_radps, 1e-6, 100},
      {"restart_probability", &O::restart_probability, 1e-30, 0.5},
      {"min_alternative_distance_m", &O::min_alternative_distance_m, 1e-3, 1000},
      {"min_alternative_turn_rad", &O::min_alternative_turn_rad, 1e-3, 10},
      {"log_likelihood_per_fit", &O::log_likelihood_per_fit, 0, 1000, "scans tell nothing apart"},
      {"min_probability_ratio", &O::min_probability_ratio, 1e-12, 1, "the best hypothesis is sure"},
      {"min_registered_interval_ms", &O::min_registered_interval, 1, 1e5},
      {"max_registered_interval_ms", &O::max_registered_interval, 1, 1e6},
      {"decisive_log_ratio", &O::decisive_log_ratio, 0, 100, "each registration counts besides"},
      {"registered_sigma_m", &O::registered_sigma_m, 1e-6, 100},
      {"registered_sigma_rad", &O::registered_sigma_rad, 1e-6, 1},
      {"max_trial_spans", &O::max_trial_spans, 1, 1000},
      {"trial_span_ms", &O::trial_span, 1, 1e6},
      {"false_registration_fraction", &O::false_registration_fraction, 1e-9, 0.5},
  };
  return kFields;
}

absl::Status Validate(const SourceMonitorOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

SourceMonitor::SourceMonitor(const SourceMonitorOptions& options,
                             const StaticPointsOptions& static_points)
    : options_(options),
      static_gate_mps_(static_points.static_gate_mps),
      static_gate_sigmas_(static_points.static_gate_sigmas) {
  for (std::size_t i = 0; i < kHypothesisCount; ++i) hypotheses_[i].sound = OdometrySources(i);
  ForgetStates();
  Begin({});
  used_ = best().sound;
}

bool SourceMonitor::SaysStanding(const std::optional<ScalarEstimate>& speed) const {
  return speed && std::abs(speed->value) <= kStandingSigmas * std::max(options_.min_speed_sigma_mps,
                                                                       std::sqrt(speed->variance));
}

void SourceMonitor::Begin(const OdometryReadings& readings) {
  const OdometrySources all(kHypothesisCount - 1);
  const Transitions transitions =
      TransitionsIn(SecondsOf(options_.start_span), readings.doppler_direction_count,
                    SaysStanding(readings.doppler_speed) ? options_.standing_doppler_failure_rate_hz
                                                         : options_.min_doppler_failure_rate_hz);
  for (Hypothesis& hypothesis : hypotheses_) {
    hypothesis.log_weight = LogTransition(all, hypothesis.sound, transitions);
    hypothesis.log_evidence = 0.0;
  }
}

// The first radar that is heard may be the one that is wrong. Once all are, it is one of several.
bool SourceMonitor::Joins(Stamp stamp, const OdometryReadings& readings) {
  if (!began_) began_ = stamp;
  const std::size_t before = doppler_radar_count_;
  doppler_radar_count_ = std::max(before, readings.doppler_radar_count);
  return before > 0 && doppler_radar_count_ > before && stamp - *began_ <= options_.start_span;
}

void SourceMonitor::ForgetStates() {
  for (Hypothesis& hypothesis : hypotheses_) {
    hypothesis.speed.variance = SquareOf(options_.unknown_speed_sigma_mps);
    hypothesis.yaw_rate.variance = SquareOf(options_.silent_yaw_rate_sigma_radps);
  }
  before_ = {};
}

// No source is as certain as it claims.
OdometryReadings SourceMonitor::WithFloors(const OdometryReadings& readings) const {
  OdometryReadings floored = readings;
  const auto floor_speed = [&](std::optional<ScalarEstimate>& speed) {
    if (!speed) return;
    *speed = Floored(*speed, options_.min_speed_sigma_mps +
                                 options_.min_speed_sigma_fraction * std::abs(speed->value));
  };
  const auto floor_yaw_rate = [&](std::optional<ScalarEstimate>& yaw_rate) {
    if (yaw_rate) *yaw_rate = Floored(*yaw_rate, options_.min_yaw_rate_sigma_radps);
  };
  floor_speed(floored.wheel_speed);
  floor_speed(floored.doppler_speed);
  floor_speed(floored.alternative_speed);
  floor_yaw_rate(floored.yaw_rate);
  floor_yaw_rate(floored.doppler_yaw_rate);
  floor_yaw_rate(floored.alternative_yaw_rate);
  if (floored.single_radar) {
    ScalarEstimate& yaw_rate = floored.single_radar->yaw_rate;
    yaw_rate = Floored(yaw_rate, options_.min_yaw_rate_sigma_radps);
  }
  // Range rates that are all 0, as compensated ones are, agree with a gyroscope on a straight road.
  const bool wheels_move = floored.wheel_speed && !SaysStanding(floored.wheel_speed);
  if (wheels_move && SaysStanding(floored.doppler_speed)) {
    floored.doppler_yaw_rate.reset();
    floored.single_radar.reset();
  }
  return floored;
}

void SourceMonitor::OnReadings(Stamp stamp, const OdometryReadings& readings) {
  if (newest_) since_used_s_ = SecondsOf(stamp - *newest_);
  newest_ = stamp;
  travel_.OnReadings(readings);
  if (compared_ && stamp - *compared_ < options_.interval) return;
  const bool joins = Joins(stamp, readings);
  if (!compared_ || joins) Begin(readings);
  if (joins) ForgetStates();
  const double duration_s = compared_ ? SecondsOf(stamp - *compared_) : 0.0;
  const Transitions transitions =
      TransitionsIn(duration_s, readings.doppler_direction_count,
                    MayBeKnocked(readings) ? options_.knocked_radar_rate_hz
                                           : options_.min_doppler_failure_rate_hz);
  Hypotheses next;
  for (std::size_t i = 0; i < kHypothesisCount; ++i) {
    next[i] = MostProbablePredecessor(OdometrySources(i), duration_s, transitions);
  }
  hypotheses_ = next;

  const OdometryReadings floored = WithFloors(readings);
  for (Hypothesis& hypothesis : hypotheses_) {
    // Where the motion is unlike any prediction, its filter begins anew, with a small probability.
    Hypothesis restarted = hypothesis;
    restarted.speed.variance = SquareOf(options_.unknown_speed_sigma_mps);
    restarted.yaw_rate.variance = SquareOf(options_.silent_yaw_rate_sigma_radps);
    restarted.log_weight += std::log(options_.restart_probability);
    Update(hypothesis, floored, duration_s);
    Update(restarted, floored, duration_s);
    const bool restarts = restarted.log_weight > hypothesis.log_weight;
    if (restarts) hypothesis = restarted;
    if (restarts || joins) {
      hypothesis.previous_speed_mps = hypothesis.speed.value;
      hypothesis.previous_yaw_rate_radps = hypothesis.yaw_rate.value;
    }
  }
  if (!compared_ || joins) DoubtFastReverse();
  DoubtStanding(floored);
  Normalize();
  TryOthers(stamp, readings);
  yaw_rate_is_stuck_ =
      readings.yaw_rate_is_repeated && (yaw_rate_is_stuck_ || !IsSound(OdometrySource::kYawRate));
  before_ = floored;
  compared_ = stamp;
  if (readings.wheel_speed) last_reported_.wheel_speed = stamp;
  if (readings.yaw_rate) last_reported_.yaw_rate = stamp;
  if (readings.doppler_speed) last_reported_.doppler_speed = stamp;
  if (readings.doppler_yaw_rate || readings.single_radar) last_reported_.doppler_yaw_rate = stamp;
}

// Hypotheses that explain the readings equally well stay as probable as they are unless a
// registration tells them apart. So they begin anew without the best one, with which nothing was
// registered; each as if its sources had been sound since the last registration.
void SourceMonitor::TryOthers(Stamp stamp, const OdometryReadings& readings) {
  if (!accepted_or_tried_ || best().sound.all()) OnSourcesFit(stamp);
  if (stamp - *accepted_or_tried_ < trial_count_ * options_.trial_span) return;
  accepted_or_tried_ = stamp;
  // With the right sources, too, finding the place takes a while.
  trial_count_ = std::min(2 * trial_count_, options_.max_trial_spans);
  const std::size_t refuted = best_;
  yaw_rate_is_stuck_ = false;
  Begin(readings);
  for (Hypothesis& hypothesis : hypotheses_) {
    hypothesis.unapplied = hypothesis.unseen = travel_.BeyondUsed(hypothesis.sound);
  }
  DoubtFastReverse();
  hypotheses_[refuted].log_weight = -options_.max_log_ratio;
  Normalize();
}

void SourceMonitor::OnSourcesFit(Stamp stamp) {
  accepted_or_tried_ = stamp;
  travel_.Begin();
}

// METHOD eq 42: of the hypotheses that may have become this one, the most probable, carried on.
SourceMonitor::Hypothesis SourceMonitor::MostProbablePredecessor(
    const OdometrySources& sound, double duration_s, const Transitions& transitions) const {
  const Hypothesis* chosen = nullptr;
  double chosen_log_weight = -std::numeric_limits<double>::infinity();
  for (const Hypothesis& before : hypotheses_) {
    const double log_weight = before.log_weight + LogTransition(before.sound, sound, transitions);
    if (log_weight <= chosen_log_weight) continue;
    chosen_log_weight = log_weight;
    chosen = &before;
  }
  Hypothesis next = chosen == nullptr ? best() : *chosen;
  next.sound = sound;
  next.log_weight = chosen_log_weight;
  const auto walk = [duration_s](ScalarEstimate& state, double rate, double unknown) {
    state.variance = std::min(state.variance + SquareOf(rate * duration_s), SquareOf(unknown));
  };
  walk(next.speed, options_.acceleration_sigma_mps2, options_.unknown_speed_sigma_mps);
  walk(next.yaw_rate, options_.yaw_acceleration_sigma_radps2, options_.silent_yaw_rate_sigma_radps);
  return next;
}

// METHOD eq 43. A failed source has changed by as much, since the last comparison, as a vehicle may
// have: otherwise it would be likelier than a sound one where scans are rare.
void SourceMonitor::Update(Hypothesis& hypothesis, const OdometryReadings& readings,
                           double duration_s) const {
  const double changing_s = std::max(duration_s, SecondsOf(options_.interval));
  const auto compare = [&](std::size_t source, const std::optional<ScalarEstimate>& reading,
                           const std::optional<ScalarEstimate>& before, double walk, double range,
                           ScalarEstimate& state) {
    if (!reading) return;
    hypothesis.log_weight += hypothesis.sound[source]
                                 ? KalmanUpdate(*reading, state)
                                 : FailedLogDensity(*reading, before, SquareOf(walk * changing_s),
                                                    range, options_.unchanged_fraction);
  };
  const double acceleration_mps2 = options_.acceleration_sigma_mps2;
  const double yaw_acceleration_radps2 = options_.yaw_acceleration_sigma_radps2;
  const auto wheel_speed = [&](const OdometryReadings& of) {
    return hypothesis.sound[kDoppler] ? of.wheel_speed
                                      : Divided(of.wheel_speed, of.doppler_multiple);
  };
  compare(kWheelSpeed, wheel_speed(readings), wheel_speed(before_), acceleration_mps2,
          options_.speed_range_mps, hypothesis.speed);
  compare(kYawRate, readings.yaw_rate, before_.yaw_rate, yaw_acceleration_radps2,
          options_.yaw_rate_range_radps, hypothesis.yaw_rate);
  // Of two motions that the targets agree on, a hypothesis takes the one nearer to its prediction.
  const bool takes_alternative = hypothesis.sound[kDoppler] && readings.alternative_speed &&
                                 LogDensity(*readings.alternative_speed, hypothesis.speed) >
                                     LogDensity(*readings.doppler_speed, hypothesis.speed);
  // One that errs by a constant share tells the motion as well as one that does not.
  const bool may_err_by_share = !hypothesis.sound[kDoppler] && hypothesis.sound[kWheelSpeed] &&
                                readings.doppler_speed && readings.doppler_multiple != 1.0;
  std::optional<Hypothesis> by_share;
  if (may_err_by_share) by_share = ByShareOfDoppler(hypothesis, readings);
  compare(kDoppler, takes_alternative ? readings.alternative_speed : readings.doppler_speed,
          before_.doppler_speed, acceleration_mps2, options_.speed_range_mps, hypothesis.speed);
  compare(kDoppler, takes_alternative ? readings.alternative_yaw_rate : readings.doppler_yaw_rate,
          before_.doppler_yaw_rate, yaw_acceleration_radps2, options_.yaw_rate_range_radps,
          hypothesis.yaw_rate);
  if (by_share && by_share->log_weight > hypothesis.log_weight) hypothesis = *by_share;
  if (readings.single_radar && hypothesis.sound[kDoppler]) {
    UpdateBySingleRadar(hypothesis, *readings.single_radar);
  }
}

SourceMonitor::Hypothesis SourceMonitor::ByShareOfDoppler(const Hypothesis& before,
                                                          const OdometryReadings& readings) {
  const double multiple = readings.doppler_multiple;
  Hypothesis by_share = before;
  by_share.log_weight += KalmanUpdate(*Divided(readings.doppler_speed, multiple), by_share.speed);
  if (const auto yaw_rate = Divided(readings.doppler_yaw_rate, multiple)) {
    by_share.log_weight += KalmanUpdate(*yaw_rate, by_share.yaw_rate);
  }
  return by_share;
}

// Its turn contradicts a gyroscope, or says nothing of it. Without one it is what is known; but a
// turn that begins faster than vehicles begin one is that of a radar that was knocked.
void SourceMonitor::UpdateBySingleRadar(Hypothesis& hypothesis, const SingleRadarReading& reading) {
  if (hypothesis.sound[kYawRate]) {
    hypothesis.log_weight -=
        0.5 * SquareOf(reading.beyond_gyroscope_radps) / reading.yaw_rate.variance;
  } else {
    const double squared_sigmas = SquareOf(reading.yaw_rate.value - hypothesis.yaw_rate.value) /
                                  (reading.yaw_rate.variance + hypothesis.yaw_rate.variance);
    hypothesis.log_weight -= 0.5 * std::max(0.0, squared_sigmas - SquareOf(kUsualSigmas));
    KalmanUpdate(reading.yaw_rate, hypothesis.yaw_rate);
  }
}

// What it says is true by chance on a straight road.
void SourceMonitor::DoubtStuckYawRate() {
  for (Hypothesis& with : hypotheses_) {
    if (!with.sound[kYawRate]) continue;
    OdometrySources sound = with.sound;
    sound.reset(kYawRate);
    const double log_without = hypotheses_[sound.to_ulong()].log_weight;
    with.log_weight = std::min(with.log_weight, log_without - options_.stuck_log_ratio);
  }
}

void SourceMonitor::Normalize() {
  if (yaw_rate_is_stuck_) DoubtStuckYawRate();
  double greatest = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < kHypothesisCount; ++i) {
    if (hypotheses_[i].log_weight <= greatest) continue;
    greatest = hypotheses_[i].log_weight;
    best_ = i;
  }
  for (Hypothesis& hypothesis : hypotheses_) {
    hypothesis.log_weight = std::max(-options_.max_log_ratio, hypothesis.log_weight - greatest);
  }
}

}  // namespace dcloc
