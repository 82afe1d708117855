#include "core/localizer/odometry_scale.h"

#include <algorithm>
#include <cmath>

namespace dcloc {

OdometryScale::OdometryScale(const OdometryScaleOptions& options)
    : options_(options), variance_(options.prior_sigma * options.prior_sigma) {}

double OdometryScale::sigma() const { return std::sqrt(variance_); }

void OdometryScale::OnMotion(const Pose3& T_from_to) {
  T_begin_now_ = T_begin_now_ * T_from_to;
  way_m_ += T_from_to.translation_m.norm();
}

void OdometryScale::OnPose(const Pose3& T_map_vehicle) {
  if (T_map_begin_ && way_m_ < options_.distance_m) return;
  const double by_odometry_m = T_begin_now_.translation_m.norm();
  // After a turn the chord says little about the way.
  if (T_map_begin_ && by_odometry_m > 0.5 * way_m_) {
    const double in_map_m = (T_map_vehicle.translation_m - T_map_begin_->translation_m).norm();
    const double error = factor_ * in_map_m / by_odometry_m - factor_;
    const double gain = variance_ / (variance_ + Noise(error, by_odometry_m));
    factor_ += gain * error;
    variance_ = std::max((1.0 - gain) * variance_, options_.min_sigma * options_.min_sigma);
  }
  T_map_begin_ = T_map_vehicle;
  T_begin_now_ = Pose3{};
  way_m_ = 0.0;
}

double OdometryScale::Noise(double error, double distance_m) {
  constexpr double kForget = 0.98;
  constexpr double kMaxSquaredSigmas = 9.0;  // what is further off must not count for all others
  const double expected = 2.0 * std::pow(options_.pose_sigma_m / distance_m, 2);
  squared_error_ = kForget * squared_error_ + std::min(error * error / expected, kMaxSquaredSigmas);
  count_ = kForget * count_ + 1.0;
  return expected * (options_.prior_count + squared_error_) / (options_.prior_count + count_);
}

}  // namespace dcloc
