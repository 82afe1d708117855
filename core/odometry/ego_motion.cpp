#include "core/odometry/ego_motion.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace dcloc {
namespace {

// Squared Mahalanobis distance of two independent estimates, over v_x and yaw rate: the components
// that both really measure.
double SquaredDistance(const EgoVelocity& a, const EgoVelocity& b) {
  const Matrix6d sum = *a.covariance + *b.covariance;
  const Eigen::Vector2d apart(a.linear_mps.x() - b.linear_mps.x(),
                              a.angular_radps.z() - b.angular_radps.z());
  Eigen::Matrix2d spread;
  spread << sum(0, 0), sum(0, 5), sum(5, 0), sum(5, 5);
  return apart.dot(spread.ldlt().solve(apart));
}

}  // namespace

std::span<const OptionField<EgoMotionOptions>> FieldsOf(const EgoMotionOptions& /*options*/) {
  using O = EgoMotionOptions;
  static constexpr OptionField<O> kFields[] = {
      {"max_squared_distance", &O::max_squared_distance, 0, 1e6, "Doppler is used alone or not"},
      {"simultaneous_ms", &O::simultaneous, 0, 1e4, "each scan stands alone"},
      {"unknown_speed_sigma_mps", &O::unknown_speed_sigma_mps, 1e-6, 1000},
      {"unknown_yaw_rate_sigma_radps", &O::unknown_yaw_rate_sigma_radps, 1e-6, 100},
  };
  return kFields;
}

absl::Status Validate(const EgoMotionOptions& options) {
  absl::Status status = ValidateFields(options, FieldsOf(options));
  status.Update(Within("doppler", Validate(options.doppler)));
  status.Update(Within("motion", Validate(options.motion)));
  status.Update(Within("error_filter", Validate(options.error_filter)));
  return status;
}

const EgoVelocity& EgoMotion::Advance(const Scan& scan, const RadarModel& radar,
                                      EgoVelocityMemory& memory) {
  const auto seed = static_cast<std::uint64_t>(scan.stamp.time_since_epoch().count());
  const std::optional<DopplerEgoVelocity> doppler =
      EstimateEgoVelocity(Remember(scan, radar), seed, options_.doppler, memory);
  const std::chrono::nanoseconds age =
      velocity_ ? scan.stamp - stamp_ : std::chrono::nanoseconds(0);

  EgoVelocity now;
  if (scan.ego_velocity) {
    now = Corrected(*scan.ego_velocity);
    // Doppler that contradicts the wheels may be that of a mover that fills the view.
    if (doppler && SquaredDistance(now, doppler->ego_velocity) <= options_.max_squared_distance) {
      now = Fuse(now, doppler->ego_velocity);
    }
  } else if (doppler) {
    now = doppler->ego_velocity;
  } else {
    now = Held(age);
  }
  since_previous_ = velocity_ ? Integrate(*velocity_, now, age, options_.motion) : Motion{};
  errors_.OnMotion(since_previous_.T_from_to, age);
  velocity_ = now;
  stamp_ = scan.stamp;
  return *velocity_;
}

EgoVelocity EgoMotion::Corrected(const EgoVelocity& reported) const {
  EgoVelocity corrected = reported;
  corrected.linear_mps *= errors_.scale();
  corrected.angular_radps.z() += errors_.yaw_rate_bias_radps();
  return WithCovariance(corrected, errors_.scale_sigma(), options_.motion);
}

// The newest scan of each radar, as far as they are of one moment.
std::span<const RadarScan> EgoMotion::Remember(const Scan& scan, const RadarModel& radar) {
  RecentScan& newest = recent_[radar.id];
  newest.scan = scan;  // into the columns of the radar's last one
  newest.radar = &radar;
  of_one_moment_.clear();
  for (const auto& [id, recent] : recent_) {
    if (scan.stamp - recent.scan.stamp > options_.simultaneous) continue;
    of_one_moment_.push_back({&recent.scan, recent.radar});
  }
  return of_one_moment_;
}

EgoVelocity EgoMotion::Held(std::chrono::nanoseconds age) const {
  EgoVelocity held = velocity_.value_or(EgoVelocity{});
  if (!velocity_) {
    Vector6d sigmas;
    sigmas << options_.unknown_speed_sigma_mps, 0.5, 0.1, 0.05, 0.05,
        options_.unknown_yaw_rate_sigma_radps;
    held.covariance = sigmas.cwiseAbs2().asDiagonal();
    return held;
  }
  const double age_s = std::chrono::duration<double>(age).count();
  (*held.covariance)(0, 0) += std::pow(options_.motion.acceleration_sigma_mps2 * age_s, 2);
  (*held.covariance)(5, 5) += std::pow(options_.motion.yaw_acceleration_sigma_radps2 * age_s, 2);
  return held;
}

}  // namespace dcloc
