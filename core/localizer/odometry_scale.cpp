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
    const double noise = 2.0 * std::pow(options_.pose_sigma_m / by_odometry_m, 2);
    const double gain = variance_ / (variance_ + noise);
    factor_ += gain * (factor_ * in_map_m / by_odometry_m - factor_);
    variance_ = std::max((1.0 - gain) * variance_, options_.min_sigma * options_.min_sigma);
  }
  T_map_begin_ = T_map_vehicle;
  T_begin_now_ = Pose3{};
  way_m_ = 0.0;
}

}  // namespace dcloc
