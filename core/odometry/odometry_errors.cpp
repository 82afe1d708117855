#include "core/odometry/odometry_errors.h"

namespace dcloc {

void OdometryErrors::Divide() {
  if (!without_doppler_) without_doppler_ = by_doppler_;
}

void OdometryErrors::OnDopplersScale(const ScalarEstimate& scale) {
  Divide();
  by_doppler_.OnScale(scale);
}

void OdometryErrors::OnDopplersScaleChange(const ScalarEstimate& change) {
  Divide();
  by_doppler_.OnScaleChange(change);
}

void OdometryErrors::ForgetScale(double sigma) {
  by_doppler_.OnScaleChange({.variance = sigma * sigma});
  if (without_doppler_) without_doppler_->OnScaleChange({.variance = sigma * sigma});
}

void OdometryErrors::OnDopplersSoundness(bool is_sound, bool is_certain) {
  uses_doppler_ = is_sound;
  if (!is_certain || !without_doppler_) return;
  if (!is_sound) by_doppler_ = *without_doppler_;
  without_doppler_.reset();
}

void OdometryErrors::OnMotion(const Pose3& T_from_to, std::chrono::nanoseconds duration,
                              OdometryErrorFilter::SpeedOrigin speed_origin) {
  const double scale_in_use = in_use().scale();
  const auto move = [&](OdometryErrorFilter& filter) {
    Pose3 own = T_from_to;
    if (speed_origin == OdometryErrorFilter::SpeedOrigin::kWheels) {
      own.translation_m *= filter.scale() / scale_in_use;
    }
    filter.OnMotion(own, duration, speed_origin);
  };
  move(by_doppler_);
  if (without_doppler_) move(*without_doppler_);
}

void OdometryErrors::OnPose(const Pose3& T_map_vehicle, const Eigen::Matrix3d& covariance) {
  by_doppler_.OnPose(T_map_vehicle, covariance);
  if (without_doppler_) without_doppler_->OnPose(T_map_vehicle, covariance);
}

void OdometryErrors::OnDiscontinuity() {
  by_doppler_.OnDiscontinuity();
  if (without_doppler_) without_doppler_->OnDiscontinuity();
}

void OdometryErrors::OnDoubt() {
  by_doppler_.OnDoubt();
  if (without_doppler_) without_doppler_->OnDoubt();
}

}  // namespace dcloc
