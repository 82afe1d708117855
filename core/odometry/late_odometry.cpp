#include "core/odometry/late_odometry.h"

#include <algorithm>
#include <cmath>

#include "core/radar/stamp.h"

namespace dcloc {
std::span<const OptionField<LateOdometryOptions>> FieldsOf(const LateOdometryOptions& /*options*/) {
  using O = LateOdometryOptions;
  static constexpr OptionField<O> kFields[] = {
      {"acceleration_sigma_mps2", &O::acceleration_sigma_mps2, 1e-6, 100},
      {"acceleration_walk_mps2", &O::acceleration_walk_mps2, 1e-6, 100},
      {"yaw_acceleration_sigma_radps2", &O::yaw_acceleration_sigma_radps2, 1e-6, 100},
      {"yaw_acceleration_walk_radps2", &O::yaw_acceleration_walk_radps2, 1e-6, 100},
      {"first_speed_sigma_mps", &O::first_speed_sigma_mps, 1e-6, 1000},
      {"first_yaw_rate_sigma_radps", &O::first_yaw_rate_sigma_radps, 1e-6, 100},
      {"doppler_speed_sigma_mps", &O::doppler_speed_sigma_mps, 1e-6, 100},
      {"doppler_yaw_rate_sigma_radps", &O::doppler_yaw_rate_sigma_radps, 1e-6, 10},
      {"offset_speed_sigma_mps", &O::offset_speed_sigma_mps, 0, 100, "both say the same"},
      {"offset_yaw_rate_sigma_radps", &O::offset_yaw_rate_sigma_radps, 0, 10, "both say the same"},
      {"offset_speed_walk_mps", &O::offset_speed_walk_mps, 0, 100, "they differ by a constant"},
      {"offset_yaw_rate_walk_radps", &O::offset_yaw_rate_walk_radps, 0, 10,
       "they differ by a constant"},
  };
  return kFields;
}

absl::Status Validate(const LateOdometryOptions& options) {
  absl::Status status = ValidateFields(options, FieldsOf(options));
  status.Update(Within("delay", Validate(options.delay)));
  return status;
}

LateOdometry::LateOdometry(const LateOdometryOptions& options)
    : options_(options), estimator_(options.delay) {}

void LateOdometry::OnReported(Stamp stamp, const EgoVelocity& reported) {
  estimator_.OnReported(stamp, reported.linear_mps.x(), reported.angular_radps.z());
}

void LateOdometry::OnDoppler(Stamp stamp, const EgoVelocity& doppler) {
  estimator_.OnDoppler(stamp, doppler.linear_mps.x(), doppler.angular_radps.z());
}

EgoVelocity LateOdometry::WithDelayUncertainty(const EgoVelocity& reported) const {
  if (!delay_s()) return reported;
  EgoVelocity wider = reported;
  (*wider.covariance)(0, 0) += std::pow(options_.acceleration_sigma_mps2 * delay_s()->value, 2);
  (*wider.covariance)(5, 5) +=
      std::pow(options_.yaw_acceleration_sigma_radps2 * delay_s()->value, 2);
  return wider;
}

void LateOdometry::Reset() {
  speed_.reset();
  yaw_rate_.reset();
  advanced_.reset();
  reported_.reset();
  T_previous_now_.reset();
}

LateSignalNoise LateOdometry::SpeedNoise() const {
  return {.unknown_sigma = options_.first_speed_sigma_mps,
          .change_sigma = options_.acceleration_sigma_mps2,
          .change_walk = options_.acceleration_walk_mps2,
          .offset_sigma = options_.offset_speed_sigma_mps,
          .offset_walk = options_.offset_speed_walk_mps};
}

LateSignalNoise LateOdometry::YawRateNoise() const {
  return {.unknown_sigma = options_.first_yaw_rate_sigma_radps,
          .change_sigma = options_.yaw_acceleration_sigma_radps2,
          .change_walk = options_.yaw_acceleration_walk_radps2,
          .offset_sigma = options_.offset_yaw_rate_sigma_radps,
          .offset_walk = options_.offset_yaw_rate_walk_radps};
}

EgoVelocity LateOdometry::ExtrapolatedToNow(Stamp stamp, const EgoVelocity& reported,
                                            const EgoVelocity* doppler,
                                            const OdometrySources& sound) {
  if (!delay_s()) {
    Reset();
    return reported;
  }
  const bool speed_is_sound = Contains(sound, OdometrySource::kWheelSpeed);
  const bool yaw_rate_is_sound = Contains(sound, OdometrySource::kYawRate);
  EgoVelocity now = WithDelayUncertainty(reported);
  const std::chrono::nanoseconds duration =
      advanced_ ? stamp - *advanced_ : std::chrono::nanoseconds(0);
  const double duration_s = SecondsOf(duration);
  advanced_ = stamp;
  // Moments that follow one another sooner share their scans.
  const bool doppler_is_new =
      doppler != nullptr && (!doppler_ || stamp - *doppler_ >= options_.delay.interval);
  if (doppler_is_new) doppler_ = stamp;
  const auto bring = [&](std::optional<LateSignal>& signal, bool is_sound,
                         const LateSignalNoise& noise, const ScalarEstimate& late,
                         const ScalarEstimate& prompt, double& value, double& variance) {
    if (!is_sound) return signal.reset();
    if (!signal) signal.emplace(noise);
    signal->Advance(duration_s);
    signal->OnLate(late, delay_s()->value);
    if (doppler_is_new) signal->OnPrompt(prompt);
    value = signal->now().value;
    variance = std::max(late.variance, signal->now().variance);
  };
  const ScalarEstimate doppler_speed{doppler_is_new ? doppler->linear_mps.x() : 0.0,
                                     std::pow(options_.doppler_speed_sigma_mps, 2)};
  const ScalarEstimate doppler_yaw_rate{doppler_is_new ? doppler->angular_radps.z() : 0.0,
                                        std::pow(options_.doppler_yaw_rate_sigma_radps, 2)};
  bring(speed_, speed_is_sound, SpeedNoise(),
        {reported.linear_mps.x(), (*reported.covariance)(0, 0)}, doppler_speed, now.linear_mps.x(),
        (*now.covariance)(0, 0));
  bring(yaw_rate_, yaw_rate_is_sound, YawRateNoise(),
        {reported.angular_radps.z(), (*reported.covariance)(5, 5)}, doppler_yaw_rate,
        now.angular_radps.z(), (*now.covariance)(5, 5));
  if (speed_is_sound && yaw_rate_is_sound) {
    Move(reported, now, duration);
  } else {
    reported_.reset();
    T_previous_now_.reset();
  }
  return now;
}

// Reports sum up to where the vehicle was, without an error; what it did since is the mean of what
// it did then and does now. So no error of that adds up.
void LateOdometry::Move(const EgoVelocity& reported, const EgoVelocity& now,
                        std::chrono::nanoseconds duration) {  // METHOD eq 47
  Vector6d since;
  since << reported.linear_mps + now.linear_mps, reported.angular_radps + now.angular_radps;
  const Pose3 T_late_now = Exp(Vector6d(0.5 * delay_s()->value * since));
  T_previous_now_.reset();
  if (reported_) {
    T_previous_now_ = T_late_now_.Inverse() *
                      Integrate(*reported_, reported, duration, {}).T_from_to * T_late_now;
  }
  reported_ = reported;
  T_late_now_ = T_late_now;
}

}  // namespace dcloc
