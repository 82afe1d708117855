#include "core/odometry/motion.h"

#include <cmath>

#include "core/geometry/covariance.h"

namespace dcloc {
namespace {

// The velocity may have risen above the line from the one end to the other and come back: a
// triangle of a / 2 at the middle is a distance of a dt^2 / 8. A turn that went so has led aside by
// half of it, give or take, as it came early or late.
Matrix6d BetweenTheEnds(double distance_m, double duration_s, const MotionOptions& options) {
  const double eighth_s2 = duration_s * duration_s / 8.0;
  const double ahead_m = options.acceleration_sigma_mps2 * eighth_s2;
  Vector6d turn = Vector6d::Zero();
  turn(5) = options.yaw_acceleration_sigma_radps2 * eighth_s2;
  turn(1) = 0.5 * distance_m * turn(5);
  // The deviation of a fraction that is equally likely anywhere in [0, 1]: 1 / sqrt(12).
  constexpr double kUniformSigma = 0.289;
  const double aside_m = kUniformSigma * distance_m * turn(5);
  Matrix6d covariance = turn * turn.transpose();
  covariance(0, 0) += ahead_m * ahead_m;
  covariance(1, 1) += aside_m * aside_m;
  return covariance;
}

}  // namespace

std::span<const OptionField<MotionOptions>> FieldsOf(const MotionOptions& /*options*/) {
  using O = MotionOptions;
  static constexpr OptionField<O> kFields[] = {
      {"correlation_time_ms", &O::correlation_time, 1, 1e6},
      {"linear_sigma_mps", &O::linear_sigma_mps, 1e-6, 100},
      {"vertical_sigma_mps", &O::vertical_sigma_mps, 1e-6, 100},
      {"yaw_rate_sigma_radps", &O::yaw_rate_sigma_radps, 1e-6, 10},
      {"tilt_rate_sigma_radps", &O::tilt_rate_sigma_radps, 1e-6, 10},
      {"acceleration_sigma_mps2", &O::acceleration_sigma_mps2, 0, 100,
       "the velocity is constant between two scans"},
      {"yaw_acceleration_sigma_radps2", &O::yaw_acceleration_sigma_radps2, 0, 100,
       "the yaw rate is constant between two scans"},
  };
  return kFields;
}

absl::Status Validate(const MotionOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

EgoVelocity WithCovariance(const EgoVelocity& ego_velocity, double scale_sigma,
                           const MotionOptions& options) {
  if (ego_velocity.covariance) return ego_velocity;
  const double linear_sigma_mps =
      options.linear_sigma_mps + scale_sigma * ego_velocity.linear_mps.norm();
  Vector6d sigmas;
  sigmas << linear_sigma_mps, options.linear_sigma_mps, options.vertical_sigma_mps,
      options.tilt_rate_sigma_radps, options.tilt_rate_sigma_radps, options.yaw_rate_sigma_radps;
  EgoVelocity result = ego_velocity;
  result.covariance = sigmas.cwiseAbs2().asDiagonal();
  return result;
}

Motion Integrate(const EgoVelocity& begin, const EgoVelocity& end,  // METHOD eq 8, 23
                 std::chrono::nanoseconds duration, const MotionOptions& options) {
  const double duration_s = SecondsOf(duration);
  Vector6d twist;
  twist << 0.5 * (begin.linear_mps + end.linear_mps),
      0.5 * (begin.angular_radps + end.angular_radps);
  const Matrix6d twist_covariance = 0.5 * (*begin.covariance + *end.covariance);
  return {.T_from_to = Exp(Vector6d(twist * duration_s)),
          .covariance = twist_covariance * (duration_s * SecondsOf(options.correlation_time)) +
                        BetweenTheEnds(twist.x() * duration_s, duration_s, options)};
}

Motion Compose(const Motion& first, const Motion& second) {
  return {
      .T_from_to = first.T_from_to * second.T_from_to,
      .covariance = ComposeCovariance<3>(first.covariance, second.T_from_to, second.covariance)};
}

Motion Inverse(const Motion& motion) {
  return {.T_from_to = motion.T_from_to.Inverse(),
          .covariance = InvertCovariance<3>(motion.T_from_to, motion.covariance)};
}

std::pair<Motion, Motion> Split(const Motion& motion, double fraction) {
  const auto part = [&](double of_it) {
    return Motion{.T_from_to = Exp(Vector6d(of_it * Log(motion.T_from_to))),
                  .covariance = of_it * motion.covariance};
  };
  return {part(fraction), part(1.0 - fraction)};
}

}  // namespace dcloc
