#include "core/odometry/odometry_error_filter.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

namespace dcloc {
namespace {

// Where the constants stand among the states, behind the pose.
constexpr int kScale = 3;
constexpr int kYawRateBias = 4;
constexpr int kSideslip = 5;
constexpr int kTimeOffset = 6;

double Square(double value) { return value * value; }

}  // namespace

std::span<const OptionField<OdometryErrorFilterOptions>> FieldsOf(
    const OdometryErrorFilterOptions& /*options*/) {
  using O = OdometryErrorFilterOptions;
  static constexpr OptionField<O> kFields[] = {
      {"scale_sigma", &O::scale_sigma, 0, 0.5, "the scale is known to be 1"},
      {"yaw_rate_bias_sigma_radps", &O::yaw_rate_bias_sigma_radps, 0, 1,
       "the bias is known to be 0"},
      {"sideslip_sigma_rad", &O::sideslip_sigma_rad, 0, 1, "the sideslip is known to be 0"},
      {"time_offset_sigma_s", &O::time_offset_sigma_s, 0, 10, "the clocks agree"},
      {"min_scale_sigma", &O::min_scale_sigma, 0, 0.5, "a learned scale may be exact"},
      {"pose_sigma_m", &O::pose_sigma_m, 1e-6, 100},
      {"pose_sigma_rad", &O::pose_sigma_rad, 1e-6, 1},
      {"walk_sigma_m", &O::walk_sigma_m, 0, 10, "only the constants err"},
      {"walk_sigma_rad", &O::walk_sigma_rad, 0, 1, "only the constants err"},
      {"scale_drift", &O::scale_drift, 0, 0.1, "the scale is constant"},
      {"yaw_rate_bias_drift_radps", &O::yaw_rate_bias_drift_radps, 0, 0.1, "the bias is constant"},
      {"sideslip_drift_rad", &O::sideslip_drift_rad, 0, 0.1, "the sideslip is constant"},
      {"innovation_forgetting_factor", &O::innovation_forgetting_factor, 0, 1,
       "only the newest innovation counts"},
      {"max_squared_sigmas", &O::max_squared_sigmas, 1e-6, 1e6},
      {"innovation_prior_count", &O::innovation_prior_count, 1e-6, 1e6},
      {"usual_squared_sigmas", &O::usual_squared_sigmas, 1e-6, 1e6},
      {"missed_squared_sigmas", &O::missed_squared_sigmas, 0, 1e6,
       "the filter's pose begins again at each registration"},
      {"max_yaw_rate_bias_radps", &O::max_yaw_rate_bias_radps, 0, 1,
       "the bias does not change at once"},
      {"max_change_interval_ms", &O::max_change_interval, 0, 1e5, "no change at once is found"},
  };
  return kFields;
}

absl::Status Validate(const OdometryErrorFilterOptions& options) {
  absl::Status status = ValidateFields(options, FieldsOf(options));
  status.Update(Within("change", Validate(options.change)));
  return status;
}

OdometryErrorFilter::OdometryErrorFilter(const OdometryErrorFilterOptions& options)
    : options_(options), bias_change_(options.change) {
  covariance_.diagonal() << 0.0, 0.0, 0.0, Square(options.scale_sigma),
      Square(options.yaw_rate_bias_sigma_radps), Square(options.sideslip_sigma_rad),
      Square(options.time_offset_sigma_s);
}

double OdometryErrorFilter::scale_sigma() const {
  return std::max(options_.min_scale_sigma, std::sqrt(covariance_(kScale, kScale)));
}

double OdometryErrorFilter::yaw_rate_bias_sigma_radps() const {
  return std::sqrt(covariance_(kYawRateBias, kYawRateBias));
}

void OdometryErrorFilter::Restore(const std::optional<ScalarEstimate>& scale,
                                  const std::optional<ScalarEstimate>& yaw_rate_bias_radps) {
  if (scale) {
    scale_ = scale->value;
    SetVariance(kScale, std::max(scale->variance, Square(options_.scale_sigma)));
  }
  if (yaw_rate_bias_radps) {
    yaw_rate_bias_radps_ = yaw_rate_bias_radps->value;
    SetVariance(kYawRateBias, std::max(yaw_rate_bias_radps->variance,
                                       Square(options_.yaw_rate_bias_sigma_radps)));
  }
}

std::optional<ScalarEstimate> OdometryErrorFilter::LearnedScale() const {
  const double variance = covariance_(kScale, kScale);
  if (2.0 * variance > Square(options_.scale_sigma)) return std::nullopt;
  return ScalarEstimate{scale_, Square(scale_sigma())};
}

std::optional<ScalarEstimate> OdometryErrorFilter::LearnedYawRateBias() const {
  const double variance = covariance_(kYawRateBias, kYawRateBias);
  if (2.0 * variance > Square(options_.yaw_rate_bias_sigma_radps)) return std::nullopt;
  return ScalarEstimate{yaw_rate_bias_radps_, variance};
}

void OdometryErrorFilter::OnMotion(const Pose3& T_from_to, std::chrono::nanoseconds duration,
                                   SpeedOrigin speed_origin) {
  const double duration_s = std::chrono::duration<double>(duration).count();
  if (duration_s <= 0.0) return;
  const Pose2 reported = Flatten(T_from_to);
  if (last_pose_) {
    last_pose_->turn_rad += reported.yaw_rad;
    last_pose_->duration += duration;
  }
  if (!T_map_vehicle_) return;
  const Pose2 T_before_now{
      .translation_m = Eigen::Rotation2Dd(sideslip_rad_) * reported.translation_m,
      .yaw_rad = reported.yaw_rad};
  T_map_vehicle_ = *T_map_vehicle_ * Embed(T_before_now);
  velocity_ = Log(T_before_now) / duration_s;

  const Eigen::Vector2d& way_m = T_before_now.translation_m;
  Covariance by_states = Covariance::Identity();
  by_states.topLeftCorner<kPose, kPose>() = Adjoint(T_before_now.Inverse());
  if (speed_origin == SpeedOrigin::kWheels) by_states.block<2, 1>(0, kScale) = way_m / scale_;
  by_states(2, kYawRateBias) = duration_s;
  by_states.block<2, 1>(0, kSideslip) = Eigen::Vector2d(-way_m.y(), way_m.x());
  States drift;
  drift << options_.walk_sigma_m, options_.walk_sigma_m, options_.walk_sigma_rad,
      options_.scale_drift, options_.yaw_rate_bias_drift_radps, options_.sideslip_drift_rad, 0.0;
  covariance_ = by_states * covariance_ * by_states.transpose();  // METHOD eq 36
  covariance_.diagonal() += duration_s * drift.cwiseAbs2();
}

void OdometryErrorFilter::OnPose(const Pose3& T_map_vehicle, const Eigen::Matrix3d& covariance) {
  Eigen::Matrix3d noise = covariance;
  noise.diagonal().head<2>().array() += Square(options_.pose_sigma_m);
  noise(2, 2) += Square(options_.pose_sigma_rad);
  const bool has_changed = HasChangedAtOnce(Flatten(T_map_vehicle), noise);
  if (!T_map_vehicle_ || has_changed) return StartAt(T_map_vehicle, noise);

  Eigen::Matrix<double, kPose, kStates> by_states = Eigen::Matrix<double, kPose, kStates>::Zero();
  by_states.leftCols<kPose>().setIdentity();
  by_states.col(kTimeOffset) = velocity_;
  const Vector6d apart_in_space = Log(T_map_vehicle_->Inverse() * T_map_vehicle);
  const Eigen::Vector3d apart(apart_in_space(0), apart_in_space(1), apart_in_space(5));
  const Eigen::Vector3d innovation = apart - time_offset_s_ * velocity_;
  const Eigen::Matrix3d predicted = by_states * covariance_ * by_states.transpose();
  const double squared_sigmas =
      innovation.dot((predicted + noise).ldlt().solve(innovation)) / kPose;
  const Eigen::Matrix3d usual_noise = noise;
  noise *= InnovationScale(squared_sigmas);

  const Eigen::Matrix<double, kStates, kPose> gain =
      (predicted + noise).ldlt().solve(by_states * covariance_).transpose();
  const States step = gain * innovation;
  // What is not planar is taken as registered.
  T_map_vehicle_ = T_map_vehicle * Embed(Exp(Eigen::Vector3d(step.head<kPose>() - apart)));
  TakeConstants(step);
  const Covariance keep = Covariance::Identity() - gain * by_states;
  covariance_ = keep * covariance_ * keep.transpose() + gain * noise * gain.transpose();
  if (squared_sigmas > options_.missed_squared_sigmas) StartAt(T_map_vehicle, usual_noise);
}

void OdometryErrorFilter::OnScale(const ScalarEstimate& scale) {
  const States gain = covariance_.col(kScale) / (covariance_(kScale, kScale) + scale.variance);
  const States step = gain * (scale.value - scale_);
  if (T_map_vehicle_) {
    T_map_vehicle_ = *T_map_vehicle_ * Embed(Exp(Eigen::Vector3d(step.head<kPose>())));
  }
  TakeConstants(step);
  Covariance keep = Covariance::Identity();
  keep.col(kScale) -= gain;
  covariance_ = keep * covariance_ * keep.transpose() + scale.variance * gain * gain.transpose();
}

void OdometryErrorFilter::TakeConstants(const States& step) {
  scale_ += step(kScale);
  yaw_rate_bias_radps_ += step(kYawRateBias);
  sideslip_rad_ += step(kSideslip);
  time_offset_s_ += step(kTimeOffset);
}

void OdometryErrorFilter::OnScaleChange(const ScalarEstimate& change) {
  SetVariance(kScale, covariance_(kScale, kScale) + Square(scale_) * change.variance);
  scale_ *= 1.0 + change.value;
  squared_sigmas_ = count_ = 0.0;  // the innovations of late were those of the change
  OnDiscontinuity();
}

void OdometryErrorFilter::StartAt(const Pose3& T_map_vehicle, const Eigen::Matrix3d& covariance) {
  T_map_vehicle_ = T_map_vehicle;
  covariance_.topRows<kPose>().setZero();
  covariance_.leftCols<kPose>().setZero();
  covariance_.topLeftCorner<kPose, kPose>() = covariance;
}

// METHOD eq 48. Neighbouring poses alone are compared: a pose that is wrong makes two deviations of
// opposite sign, and a change makes all that follow. What is further off than a zero can be is no
// bias.
bool OdometryErrorFilter::HasChangedAtOnce(const Pose2& T_map_vehicle,
                                           const Eigen::Matrix3d& noise) {
  const std::optional<LastPose> last = std::exchange(
      last_pose_,
      LastPose{.T_map_vehicle = T_map_vehicle, .noise = noise, .turn_rad = 0.0, .duration = {}});
  if (!last || last->duration > options_.max_change_interval) return false;
  const double duration_s = std::chrono::duration<double>(last->duration).count();
  const double turn_rad = WrapAngle(T_map_vehicle.yaw_rad - last->T_map_vehicle.yaw_rad);
  const double turn_variance = InnovationScaleOfLate() * (last->noise(2, 2) + noise(2, 2)) +
                               Square(options_.walk_sigma_rad) * duration_s +
                               covariance_(kYawRateBias, kYawRateBias) * Square(duration_s);
  const std::optional<ScalarEstimate> change =
      bias_change_.OnDeviation({WrapAngle(turn_rad - last->turn_rad), turn_variance}, duration_s);
  if (!change ||
      std::abs(yaw_rate_bias_radps_ + change->value) > options_.max_yaw_rate_bias_radps) {
    return false;
  }
  yaw_rate_bias_radps_ += change->value;
  SetVariance(kYawRateBias, change->variance);
  squared_sigmas_ = count_ = 0.0;  // the innovations of late were those of the change
  return true;
}

// What else correlates with a constant says nothing of its new value.
void OdometryErrorFilter::SetVariance(int state, double variance) {
  covariance_.row(state).setZero();
  covariance_.col(state).setZero();
  covariance_(state, state) = variance;
}

double OdometryErrorFilter::InnovationScaleOfLate() const {
  return std::max(1.0, (options_.innovation_prior_count + squared_sigmas_) /
                           (options_.innovation_prior_count + count_));
}

// By how much innovations exceed their covariance, lately or now; `squared_sigmas` is the newest
// one's, for each degree of freedom (METHOD eq 37).
double OdometryErrorFilter::InnovationScale(double squared_sigmas) {
  squared_sigmas_ = options_.innovation_forgetting_factor * squared_sigmas_ +
                    std::min(squared_sigmas, options_.max_squared_sigmas);
  count_ = options_.innovation_forgetting_factor * count_ + 1.0;
  return std::max(InnovationScaleOfLate(), squared_sigmas / options_.usual_squared_sigmas);
}

}  // namespace dcloc
