// The velocity that the sources make, as far as they are sound.
#include <chrono>
#include <cmath>

#include "core/odometry/ego_motion.h"
#include "core/odometry/odometry_readings.h"

namespace dcloc {

// What is reported late was true then. Since then the vehicle has become faster as Doppler says.
double EgoMotion::WheelSpeedNow_mps(const EgoVelocity& late) const {
  if (!late_.delay_s()) return late.linear_mps.x();
  const std::chrono::nanoseconds delay(std::llround(1e9 * late_.delay_s()->value));
  return late.linear_mps.x() + acceleration_.Gain_mps(delay);
}

// Whether the wheels differ from Doppler by more than they did, and Doppler goes on as the vehicle
// has moved.
bool EgoMotion::WheelsLeap(const EgoVelocity& reported, const EgoVelocity& doppler) const {
  const double wheels_mps = WheelSpeedNow_mps(reported);
  const double doppler_mps = doppler.linear_mps.x();
  const double gain_mps = acceleration_.Gain_mps(std::chrono::seconds(1));
  if (!wheel_scale_.IsUnusual(wheels_mps / errors_.by_doppler().scale(), doppler_mps, gain_mps))
    return false;
  const double before_mps = velocity_->linear_mps.x();
  return std::abs(doppler_mps - before_mps) < std::abs(wheels_mps - before_mps);
}

EgoVelocity EgoMotion::Corrected(const EgoVelocity& reported,
                                 const OdometryErrorFilter& errors) const {
  EgoVelocity corrected = reported;
  corrected.linear_mps *= errors.scale();
  corrected.angular_radps.z() += errors.yaw_rate_bias_radps();
  EgoVelocity result = WithCovariance(corrected, errors.scale_sigma(), options_.motion);
  if (const std::optional<double> share = wheel_scale_.UnconfirmedChange()) {
    (*result.covariance)(0, 0) += std::pow(*share * corrected.linear_mps.x(), 2);
  }
  // One that is held was true when it first came.
  const double age_s = SecondsOf(outdated_by_);
  (*result.covariance)(0, 0) += std::pow(options_.motion.acceleration_sigma_mps2 * age_s, 2);
  (*result.covariance)(5, 5) += std::pow(options_.motion.yaw_acceleration_sigma_radps2 * age_s, 2);
  // A bias that is being learned afresh may still be anything.
  double& variance = (*result.covariance)(5, 5);
  variance = std::max(variance, std::pow(errors.yaw_rate_bias_sigma_radps(), 2));
  return result;
}

// What the vehicle sends and Doppler are fused as far as they are sound.
EgoVelocity EgoMotion::FromSources(const std::optional<EgoVelocity>& reported,
                                   const std::optional<DopplerEgoVelocity>& doppler,
                                   std::chrono::nanoseconds age) const {
  const bool doppler_is_sound = doppler && sources_.IsSound(OdometrySource::kDoppler);
  if (!reported && doppler_is_sound) return doppler->ego_velocity;
  if (!reported) return doppler ? FromMonitor() : Held(age);
  // A single moment's Doppler may be that of a mover, though most often it is sound.
  const bool agree = doppler_is_sound && SquaredDistance(*reported, doppler->ego_velocity) <=
                                             options_.max_squared_distance;
  const bool wheels_are_sound = sources_.IsSound(OdometrySource::kWheelSpeed) && !wheels_leap_;
  const bool gyro_is_sound = sources_.IsSound(OdometrySource::kYawRate);
  if (wheels_are_sound && gyro_is_sound) {
    return agree ? Fuse(*reported, doppler->ego_velocity) : *reported;
  }
  if (!doppler_is_sound) return FromMonitor();
  // Of the reported components the sound one counts.
  EgoVelocity sound = doppler->ego_velocity;
  Matrix6d covariance = *sound.covariance;
  covariance(0, 0) = std::pow(options_.unknown_speed_sigma_mps, 2);
  covariance(5, 5) = std::pow(options_.unknown_yaw_rate_sigma_radps, 2);
  if (wheels_are_sound) {
    sound.linear_mps.x() = reported->linear_mps.x();
    covariance(0, 0) = (*reported->covariance)(0, 0);
  }
  if (gyro_is_sound) {
    sound.angular_radps.z() = reported->angular_radps.z();
    covariance(5, 5) = (*reported->covariance)(5, 5);
  }
  sound.covariance = Matrix6d(covariance.diagonal().asDiagonal());
  return Fuse(sound, doppler->ego_velocity);
}

// Speed and yaw rate as the sound sources have had them; otherwise vehicles move as they look.
EgoVelocity EgoMotion::FromMonitor() const {
  const ScalarEstimate speed = sources_.speed();
  const ScalarEstimate yaw_rate = sources_.yaw_rate();
  EgoVelocity velocity = WithCovariance({}, 0.0, options_.motion);
  velocity.linear_mps.x() = speed.value;
  velocity.angular_radps.z() = yaw_rate.value;
  (*velocity.covariance)(0, 0) = speed.variance;
  (*velocity.covariance)(5, 5) = yaw_rate.variance;
  return velocity;
}

EgoVelocity EgoMotion::Held(std::chrono::nanoseconds age) const {
  EgoVelocity held = velocity_.value_or(EgoVelocity{});
  if (!velocity_) {
    Vector6d sigmas;
    sigmas << options_.unknown_speed_sigma_mps, options_.unknown_lateral_sigma_mps,
        options_.unknown_vertical_sigma_mps, options_.unknown_tilt_rate_sigma_radps,
        options_.unknown_tilt_rate_sigma_radps, options_.unknown_yaw_rate_sigma_radps;
    held.covariance = sigmas.cwiseAbs2().asDiagonal();
    return held;
  }
  const double age_s = std::chrono::duration<double>(age).count();
  (*held.covariance)(0, 0) += std::pow(options_.motion.acceleration_sigma_mps2 * age_s, 2);
  (*held.covariance)(5, 5) += std::pow(options_.motion.yaw_acceleration_sigma_radps2 * age_s, 2);
  return held;
}

}  // namespace dcloc
