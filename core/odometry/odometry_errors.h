#pragma once

#include <Eigen/Core>
#include <chrono>
#include <optional>

#include "core/geometry/pose.h"
#include "core/odometry/odometry_error_filter.h"
#include "core/odometry/scalar_estimate.h"

namespace dcloc {

/// What is constantly wrong with the motion that the vehicle reports, where Doppler has a say in it
/// beside the registered poses. Doppler that is suddenly another multiple of the wheels' speed is
/// one of two things: the wheels' scale has changed, or Doppler errs. Until it is decided there are
/// two filters, and both learn from poses.
class OdometryErrors {
 public:
  explicit OdometryErrors(const OdometryErrorFilterOptions& options) : by_doppler_(options) {}

  /// See OdometryErrorFilter::Restore.
  void Restore(const std::optional<ScalarEstimate>& scale,
               const std::optional<ScalarEstimate>& yaw_rate_bias_radps) {
    by_doppler_.Restore(scale, yaw_rate_bias_radps);
  }

  /// If Doppler is right.
  const OdometryErrorFilter& by_doppler() const { return by_doppler_; }

  /// If it is not; nothing where that makes no difference.
  const std::optional<OdometryErrorFilter>& without_doppler() const { return without_doppler_; }

  /// By the sources that are sound.
  const OdometryErrorFilter& in_use() const {
    return uses_doppler_ || !without_doppler_ ? by_doppler_ : *without_doppler_;
  }

  /// Doppler says what the reported speed is to be multiplied by, from now or long ago.
  void OnDopplersScale(const ScalarEstimate& scale);

  /// By Doppler, the scale is larger by this share than it was.
  void OnDopplersScaleChange(const ScalarEstimate& change);

  /// Nobody knows what the scale is any longer.
  void ForgetScale(double sigma);

  /// Whether Doppler is used, and whether that is certain: its being used, or its not being used.
  void OnDopplersSoundness(bool is_sound, bool is_certain);

  /// As of OdometryErrorFilter, for both. The motion is that of the scale in use.
  void OnMotion(
      const Pose3& T_from_to, std::chrono::nanoseconds duration,
      OdometryErrorFilter::SpeedOrigin speed_origin = OdometryErrorFilter::SpeedOrigin::kWheels);
  void OnPose(const Pose3& T_map_vehicle, const Eigen::Matrix3d& covariance);
  void OnDiscontinuity();
  void OnDoubt();

 private:
  void Divide();

  OdometryErrorFilter by_doppler_;
  std::optional<OdometryErrorFilter> without_doppler_;  // while the two differ
  bool uses_doppler_ = true;
};

}  // namespace dcloc
