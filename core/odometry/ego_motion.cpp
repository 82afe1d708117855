#include "core/odometry/ego_motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/odometry/odometry_readings.h"
#include "core/odometry/tick_motion.h"

namespace dcloc {
std::span<const OptionField<EgoMotionOptions>> FieldsOf(const EgoMotionOptions& /*options*/) {
  using O = EgoMotionOptions;
  static constexpr OptionField<O> kFields[] = {
      {"max_squared_distance", &O::max_squared_distance, 0, 1e6, "Doppler is used alone or not"},
      {"simultaneous_ms", &O::simultaneous, 0, 1e4, "each scan stands alone"},
      {"unknown_speed_sigma_mps", &O::unknown_speed_sigma_mps, 1e-6, 1000},
      {"unknown_lateral_sigma_mps", &O::unknown_lateral_sigma_mps, 1e-6, 100},
      {"unknown_vertical_sigma_mps", &O::unknown_vertical_sigma_mps, 1e-6, 100},
      {"unknown_tilt_rate_sigma_radps", &O::unknown_tilt_rate_sigma_radps, 1e-6, 10},
      {"unknown_yaw_rate_sigma_radps", &O::unknown_yaw_rate_sigma_radps, 1e-6, 100},
      {"history_ms", &O::history, 1, 1e5},
      {"max_held_distance_m", &O::max_held_distance_m, 0, 100, "what is repeated is old"},
      {"diagnosis_speed_mps", &O::diagnosis_speed_mps, 1e-6, 100},
      {"diagnosis_yaw_rate_radps", &O::diagnosis_yaw_rate_radps, 1e-6, 10},
      {"correction_sigma_fraction", &O::correction_sigma_fraction, 0, 10,
       "a correction is as certain as any other motion"},
  };
  return kFields;
}

absl::Status Validate(const EgoMotionOptions& options) {
  absl::Status status = ValidateFields(options, FieldsOf(options));
  status.Update(Within("doppler", Validate(options.doppler)));
  status.Update(Within("motion", Validate(options.motion)));
  status.Update(Within("error_filter", Validate(options.error_filter)));
  status.Update(Within("sources", Validate(options.sources)));
  status.Update(Within("late", Validate(options.late)));
  status.Update(Within("wheel_scale", Validate(options.wheel_scale)));
  status.Update(Within("disagreement", Validate(options.disagreement)));
  status.Update(Within("acceleration", Validate(options.acceleration)));
  return status;
}

void EgoMotion::Restore(const RigKnowledge& known) {
  errors_.Restore(known.wheel_scale, known.yaw_rate_correction);
  if (known.odometry_delay) late_.Restore(*known.odometry_delay);
}

void EgoMotion::AddTo(RigKnowledge& known) const {
  known.wheel_scale = errors_.in_use().LearnedScale();
  known.yaw_rate_correction = errors_.in_use().LearnedYawRateBias();
  known.odometry_delay = late_.delay_s();
}

const EgoVelocity& EgoMotion::Advance(const Scan& scan, Stamp stamp, const RadarModel& radar,
                                      EgoVelocityWorkspace& workspace) {
  const auto seed = static_cast<std::uint64_t>(scan.stamp.time_since_epoch().count());
  std::optional<DopplerEgoVelocity> doppler =
      EstimateEgoVelocity(Remember(scan, stamp, radar), seed, options_.doppler, workspace);
  std::optional<DopplerEgoVelocity> alternative;
  if (doppler)
    alternative = EstimateAlternativeEgoVelocity(*doppler, seed, options_.doppler, workspace);
  const std::chrono::nanoseconds age = velocity_ ? stamp - stamp_ : std::chrono::nanoseconds(0);
  std::optional<EgoVelocity> reported;
  if (scan.ego_velocity) {
    held_velocity_.OnReported(stamp, *scan.ego_velocity);
    repeated_yaw_rate_.OnReported(*scan.ego_velocity);
    const bool has_moved_on = std::abs(disagreement_.distance_m()) > options_.max_held_distance_m;
    if (has_moved_on || held_velocity_.IsUnusual()) held_velocity_.OnContradicted();
    outdated_by_ = doppler ? held_velocity_.age() : std::chrono::nanoseconds(0);
    const bool was_late = late_.delay_s().has_value();
    if (!is_held()) late_.OnReported(stamp, *scan.ego_velocity);
    if (late_.delay_s().has_value() != was_late) {  // the scale was learned of another moment
      errors_.ForgetScale(options_.error_filter.scale_sigma);
      wheel_scale_ = WheelScaleMonitor(options_.wheel_scale);
    }
    reported = late_.WithDelayUncertainty(Corrected(*scan.ego_velocity, errors_.by_doppler()));
  }
  const std::optional<SingleRadarReading> single_radar =
      YawRateBesideGyroscope(radar, reported, doppler);
  OdometryReadings readings =
      ReadingsOf(reported, doppler, alternative, single_radar, simultaneous_scans_.size());
  if (reported && errors_.without_doppler()) {
    readings.doppler_multiple = errors_.by_doppler().scale() / errors_.without_doppler()->scale();
  }
  readings.yaw_rate_is_repeated = reported && repeated_yaw_rate_;
  sources_.OnReadings(stamp, readings);
  errors_.OnDopplersSoundness(sources_.IsSound(OdometrySource::kDoppler),
                              sources_.IsRuledOut(OdometrySource::kDoppler) ||
                                  sources_.IsCertain(OdometrySource::kDoppler));
  if (single_radar && !sources_.IsSound(OdometrySource::kYawRate)) {
    doppler->ego_velocity.angular_radps.z() = single_radar->yaw_rate.value;
  }
  if (alternative && IsNearer(*alternative, *doppler, sources_.speed())) doppler = alternative;
  const bool doppler_is_sound = doppler && sources_.IsSound(OdometrySource::kDoppler);
  if (doppler_is_sound) {
    late_.OnDoppler(moment_, doppler->ego_velocity);
    acceleration_.OnSpeed(moment_, doppler->ego_velocity.linear_mps.x());
  }
  FollowYawRateSign(scan.ego_velocity, doppler_is_sound ? &*doppler : nullptr);
  wheels_leap_ = reported && doppler_is_sound && WheelsLeap(*reported, doppler->ego_velocity);
  FollowWheelScale(stamp, reported, doppler_is_sound ? &*doppler : nullptr);
  if (reported) {
    reported = late_.ExtrapolatedToNow(stamp, Corrected(*scan.ego_velocity, errors_.in_use()),
                                       doppler_is_sound ? &doppler->ego_velocity : nullptr,
                                       sources_.sound());
  }
  if (reported && !is_held() && doppler_is_sound && sources_.IsSound(OdometrySource::kWheelSpeed)) {
    disagreement_.OnSpeeds(stamp, reported->linear_mps.x(), doppler->ego_velocity.linear_mps.x());
  } else {
    disagreement_.OnDecided(stamp);
  }
  const EgoVelocity now = FromSources(reported, doppler, age);
  since_previous_ = velocity_ ? Integrate(*velocity_, now, age, options_.motion) : Motion{};
  if (velocity_ && follows_reports()) {
    if (const auto beyond = BeyondTheLine(scan.ticks, stamp - stamp_)) {
      since_previous_.T_from_to = since_previous_.T_from_to * *beyond;
    }
  }
  if (velocity_ && !wheels_leap_ && late_.T_previous_now())
    since_previous_.T_from_to = *late_.T_previous_now();
  expected_motion_ = since_previous_.T_from_to;
  ApplyCorrection();
  since_previous_.covariance(5, 5) += std::pow(std::exchange(reversed_turn_rad_, 0.0), 2);
  if (scale_correction_m_ != 0.0) Correct(std::exchange(scale_correction_m_, 0.0), 0.0);
  if (!wheels_leap_)
    unobserved_distance_m_ += std::abs(since_previous_.T_from_to.translation_m.x());
  Learn(reported, now, age);
  velocity_ = widened_velocity_ = now;
  AddSpread();
  history_.Add(stamp, since_previous_, *widened_velocity_);
  stamp_ = stamp;
  Diagnose(reported);
  return *widened_velocity_;
}

// By a sign that was wrong the vehicle has turned to the wrong side: twice as far from the truth.
void EgoMotion::FollowYawRateSign(const std::optional<EgoVelocity>& reported,
                                  const DopplerEgoVelocity* doppler) {
  if (!reported || is_held() || doppler == nullptr ||
      doppler->direction_count <= options_.sources.narrow_direction_count) {
    return;
  }
  const EgoVelocity& seen = doppler->ego_velocity;
  if (yaw_rate_sign_.OnYawRates(moment_, seen.linear_mps.x(), reported->angular_radps.z(),
                                seen.angular_radps.z())) {
    reversed_turn_rad_ = 2.0 * yaw_rate_sign_.turn_rad();
  }
}

// Of a single radar. One whose turn contradicts a gyroscope that was found to be right is refuted.
std::optional<SingleRadarReading> EgoMotion::YawRateBesideGyroscope(
    const RadarModel& radar, const std::optional<EgoVelocity>& reported,
    const std::optional<DopplerEgoVelocity>& doppler) {
  constexpr double kKnockedSigmas = 3.0;  // below, it may be noise
  if (simultaneous_scans_.size() != 1 || !reported || !doppler) return std::nullopt;
  SingleRadarYawRate& yaw_rate = recent_[radar.id].yaw_rate;
  const bool gyro_is_sound = sources_.IsSound(OdometrySource::kYawRate);
  const EgoVelocity& seen = doppler->ego_velocity;
  const std::optional<SingleRadarReading> reading = yaw_rate.OnYawRates(
      seen.linear_mps.x(), radar.T_vehicle_radar.translation_m.x(),
      {seen.angular_radps.z(), (*seen.covariance)(5, 5)},
      {.yaw_rate_radps = reported->angular_radps.z(), .is_sound = gyro_is_sound});
  const bool contradicts = reading && reading->beyond_gyroscope_radps >
                                          kKnockedSigmas * std::sqrt(reading->yaw_rate.variance);
  const bool is_refuted = contradicts && gyro_is_sound &&
                          !sources_.IsSound(OdometrySource::kDoppler) && !YawRateIsDisputed();
  if (!is_refuted) return reading;
  yaw_rate.OnMountChanged();
  return std::nullopt;
}

// METHOD eq 58. What a mover may have said is no evidence against wheels.
void EgoMotion::FollowWheelScale(Stamp stamp, const std::optional<EgoVelocity>& reported,
                                 const DopplerEgoVelocity* doppler) {
  if (!reported || is_held() || doppler == nullptr ||
      !sources_.IsSound(OdometrySource::kWheelSpeed) ||
      doppler->direction_count <= options_.sources.narrow_direction_count) {
    return wheel_scale_.OnUnsound();
  }
  const auto change =
      wheel_scale_.OnSpeeds(stamp, WheelSpeedNow_mps(*reported) / errors_.by_doppler().scale(),
                            doppler->ego_velocity.linear_mps.x());
  if (const auto scale = wheel_scale_.TakeScale()) {
    const double before = errors_.by_doppler().scale();
    errors_.OnDopplersScale(*scale);
    const bool agree =
        std::abs(errors_.by_doppler().scale() / before - 1.0) < options_.wheel_scale.min_change;
    if (agree) errors_.OnDopplersSoundness(/*is_sound=*/true, /*is_certain=*/true);
    if (!agree) sources_.OnDopplersScaleChange(0.0);
  }
  if (!change) return;
  scale_correction_m_ = change->share.value *
                        std::copysign(std::min(errors_.by_doppler().scale() * change->distance_m,
                                               unobserved_distance_m_),
                                      reported->linear_mps.x());
  errors_.OnDopplersScaleChange(change->share);
  sources_.OnDopplersScaleChange(scale_correction_m_);
}

// Of a gyroscope that is set aside, too: it may be taken back once its bias is known. Wheels that
// are set aside slip, and no scale describes that.
void EgoMotion::Learn(const std::optional<EgoVelocity>& reported, const EgoVelocity& now,
                      std::chrono::nanoseconds age) {
  if (is_held()) {
    reported_with_sound_wheels_.reset();
    return errors_.OnDiscontinuity();
  }
  std::optional<EgoVelocity> with_sound_wheels = reported;
  if (with_sound_wheels && !sources_.IsSound(OdometrySource::kWheelSpeed)) {
    with_sound_wheels->linear_mps = now.linear_mps;
  }
  if (follows_reports()) {
    errors_.OnMotion(since_previous_.T_from_to, age);
  } else if (with_sound_wheels && reported_with_sound_wheels_) {
    using Origin = OdometryErrorFilter::SpeedOrigin;
    errors_.OnMotion(
        Integrate(*reported_with_sound_wheels_, *with_sound_wheels, age, options_.motion).T_from_to,
        age, sources_.IsSound(OdometrySource::kWheelSpeed) ? Origin::kWheels : Origin::kOther);
  } else {
    errors_.OnDiscontinuity();
  }
  reported_with_sound_wheels_ = with_sound_wheels;
}

void EgoMotion::Diagnose(const std::optional<EgoVelocity>& reported) {
  velocity_for_mounts_.reset();
  if (!reported) return;
  reported_stamp_ = stamp_;
  const auto compare = [this](OdometrySource source, double said, double moved,
                              SourceDiagnosis& diagnosis) {
    if (sources_.IsSound(source)) return diagnosis.Clear();
    diagnosis.OnReading(said, moved);
  };
  compare(OdometrySource::kWheelSpeed, reported->linear_mps.x(), sources_.speed().value,
          wheel_speed_diagnosis_);
  compare(OdometrySource::kYawRate, reported->angular_radps.z(), sources_.yaw_rate().value,
          yaw_rate_diagnosis_);
  if (is_held() || YawRateIsDisputed() || !sources_.IsSound(OdometrySource::kYawRate)) return;
  velocity_for_mounts_ = reported;
  if (!sources_.IsSound(OdometrySource::kWheelSpeed)) {
    velocity_for_mounts_->linear_mps = {sources_.speed().value, 0.0, 0.0};
  }
}

SourceHealth EgoMotion::HealthOf(OdometrySource source, const SourceDiagnosis& diagnosis) const {
  if (!reported_stamp_ || stamp_ - *reported_stamp_ > options_.sources.silent_after) {
    return {.is_used = false, .fault = SourceFault::kSilent};
  }
  if (sources_.IsSound(source)) {
    return {.is_used = true, .fault = late_.delay_s() ? SourceFault::kDelay : SourceFault::kNone};
  }
  return {.is_used = false, .fault = diagnosis.fault()};
}

SourceHealth EgoMotion::wheel_speed() const {
  return HealthOf(OdometrySource::kWheelSpeed, wheel_speed_diagnosis_);
}

SourceHealth EgoMotion::yaw_rate() const {
  SourceHealth health = HealthOf(OdometrySource::kYawRate, yaw_rate_diagnosis_);
  if (health.is_used && yaw_rate_is_reversed()) health.fault = SourceFault::kSign;
  const bool is_aside = !health.is_used && health.fault != SourceFault::kSilent;
  if (is_aside && repeated_yaw_rate_) health.fault = SourceFault::kFrozen;
  return health;
}

void EgoMotion::ApplyCorrection() {
  const Pose2 used = Flatten(since_previous_.T_from_to);
  const auto unapplied = sources_.OnUsedMotion(used.translation_m.x(), used.yaw_rad);
  sources_changed_ = unapplied.has_value();
  if (!unapplied) return;
  Correct(unapplied->forward_m, unapplied->turn_rad);
}

void EgoMotion::Correct(double forward_m, double turn_rad) {
  Vector6d step = Vector6d::Zero();
  step(0) = forward_m;
  step(5) = turn_rad;
  const Vector6d sigmas = options_.correction_sigma_fraction * step;
  since_previous_ = Compose(
      since_previous_, {.T_from_to = Exp(step), .covariance = sigmas.cwiseAbs2().asDiagonal()});
}

// METHOD eq 49. Targets of each motion that is not improbable stay static, and the pose becomes as
// uncertain as the sources differ along-track. A spread that ends leaves it as uncertain, until a
// registration is accepted.
void EgoMotion::AddSpread() {
  const SourceMonitor::Spread counted = std::exchange(spread_, sources_.CurrentSpread());
  spread_.along_track_variance_m2 =
      std::max(spread_.along_track_variance_m2, counted.along_track_variance_m2);
  spread_.turn_variance_rad2 = std::max(spread_.turn_variance_rad2, counted.turn_variance_rad2);
  spread_since_previous_.setZero();
  spread_since_previous_(0, 0) = spread_.along_track_variance_m2 - counted.along_track_variance_m2;
  spread_since_previous_(5, 5) = spread_.turn_variance_rad2 - counted.turn_variance_rad2;
  AddHeldSpread();
  since_previous_.covariance += spread_since_previous_;
  Matrix6d& covariance = *widened_velocity_->covariance;
  covariance(0, 0) += spread_.speed_variance;
  covariance(5, 5) += spread_.yaw_rate_variance;
}

// Until it was contradicted, a velocity that is held has led the pose as if it were new. The
// vehicle may have turned otherwise meanwhile; how fast it is, Doppler said.
void EgoMotion::AddHeldSpread() {
  const double age_s =
      SecondsOf(std::min(held_velocity_.TakeTrusted(), options_.disagreement.fading));
  Vector6d step = Vector6d::Zero();
  step(5) = 0.5 * options_.motion.yaw_acceleration_sigma_radps2 * age_s * age_s;
  step(1) = velocity_->linear_mps.x() * age_s * step(5) / 3.0;
  spread_since_previous_ += step * step.transpose();
}

std::optional<EgoMotion::AlternativePlace> EgoMotion::Alternative(std::size_t radar_index) const {
  const std::optional<ArcMotion> motion = sources_.Alternative(radar_index);
  if (!motion) return std::nullopt;
  Vector6d step = Vector6d::Zero();
  step(0) = motion->forward_m;
  step(5) = motion->turn_rad;
  return AlternativePlace{.motion = *motion, .T_used_alternative = Exp(step)};
}

// The newest scan of each radar, as far as they are of one moment.
std::span<const RadarScan> EgoMotion::Remember(const Scan& scan, Stamp stamp,
                                               const RadarModel& radar) {
  RecentScan& newest = recent_[radar.id];
  newest.scan = scan;  // into the columns of the radar's last one
  newest.stamp = stamp;
  newest.radar = &radar;
  simultaneous_scans_.clear();
  ages_.clear();
  double target_count = 0.0;
  std::chrono::duration<double, std::nano> age_sum(0.0);
  for (const auto& [id, recent] : recent_) {
    if (stamp - recent.stamp > options_.simultaneous) continue;
    simultaneous_scans_.push_back({&recent.scan, recent.radar});
    ages_.push_back(stamp - recent.stamp);
    age_sum += static_cast<double>(recent.scan.size()) * (stamp - recent.stamp);
    target_count += static_cast<double>(recent.scan.size());
  }
  moment_ =
      stamp - std::chrono::round<std::chrono::nanoseconds>(age_sum / std::max(1.0, target_count));
  for (std::size_t i = 0; i < ages_.size(); ++i) {
    simultaneous_scans_[i].speed_gain_mps = acceleration_.Gain_mps(moment_ - (stamp - ages_[i]));
  }
  return simultaneous_scans_;
}

}  // namespace dcloc
