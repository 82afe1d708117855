#include "core/submap/odometry.h"

#include <cmath>

#include "core/geometry/covariance.h"

namespace dcloc {
namespace {

double Seconds(std::chrono::nanoseconds duration) {
  return std::chrono::duration<double>(duration).count();
}

}  // namespace

EgoVelocity WithCovariance(const EgoVelocity& ego_velocity, double scale_sigma,
                           const OdometryOptions& options) {
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

Motion Integrate(const EgoVelocity& begin, const EgoVelocity& end,
                 std::chrono::nanoseconds duration, const OdometryOptions& options) {
  const double duration_s = Seconds(duration);
  Vector6d twist;
  twist << 0.5 * (begin.linear_mps + end.linear_mps),
      0.5 * (begin.angular_radps + end.angular_radps);
  const Matrix6d twist_covariance = 0.5 * (*begin.covariance + *end.covariance);
  return {.T_from_to = Exp(Vector6d(twist * duration_s)),
          .covariance = twist_covariance * (duration_s * Seconds(options.correlation_time))};
}

Motion Compose(const Motion& first, const Motion& second) {
  return {
      .T_from_to = first.T_from_to * second.T_from_to,
      .covariance = ComposeCovariance<3>(first.covariance, second.T_from_to, second.covariance)};
}

}  // namespace dcloc
