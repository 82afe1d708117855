#include "core/localizer/fix_monitor.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace dcloc {
namespace {

// Of the position along the map's axes.
Eigen::Matrix2d HorizontalCovariance(const PoseEstimate<3>& estimate) {
  const Eigen::Matrix3d R = estimate.pose.Rotation();
  return (R * estimate.covariance.topLeftCorner<3, 3>() * R.transpose()).topLeftCorner<2, 2>();
}

}  // namespace

std::span<const OptionField<FixMonitorOptions>> FieldsOf(const FixMonitorOptions& /*options*/) {
  using O = FixMonitorOptions;
  static constexpr OptionField<O> kFields[] = {
      {"max_squared_distance", &O::max_squared_distance, 0.1, 1e6},
      {"max_squared_heading_distance", &O::max_squared_heading_distance, 0.1, 1e6},
      {"unknown_heading_sigma_rad", &O::unknown_heading_sigma_rad, 1e-6, 10},
      {"persistent_fixes", &O::persistent_fixes, 1, 1000},
      {"persistent_span_ms", &O::persistent_span, 0, 1e6, "the count alone decides"},
      {"refuted_span_ms", &O::refuted_span, 0, 1e9, "the pose is doubted again at once"},
      {"fusion_interval_ms", &O::fusion_interval, 1, 1e6},
      {"fusion_sigma_factor", &O::fusion_sigma_factor, 0, 1000, "no fix is fused"},
  };
  return kFields;
}

absl::Status Validate(const FixMonitorOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

FixVerdict FixMonitor::Classify(Stamp stamp, const PoseEstimate<3>& fix,
                                const PoseEstimate<3>& pose) {
  newest_ = stamp;
  if (Agree(fix, pose)) {
    contradicting_count_ = 0;
    return IsFusable(stamp, fix, pose) ? FixVerdict::kFusable : FixVerdict::kAgrees;
  }
  if (contradicting_count_++ == 0) contradicting_since_ = stamp;
  const bool persists = contradicting_count_ >= options_.persistent_fixes &&
                        stamp - contradicting_since_ >= options_.persistent_span;
  return persists && !IsRefuted(stamp) ? FixVerdict::kContradictsPersistently
                                       : FixVerdict::kContradicts;
}

bool FixMonitor::Agree(const PoseEstimate<3>& fix, const PoseEstimate<3>& pose) const {
  const Eigen::Vector2d apart = (fix.pose.translation_m - pose.pose.translation_m).head<2>();
  const Eigen::Matrix2d spread = HorizontalCovariance(fix) + HorizontalCovariance(pose);
  if (apart.dot(spread.ldlt().solve(apart)) > options_.max_squared_distance) return false;
  const double heading_variance = fix.covariance(5, 5) + pose.covariance(5, 5);
  const double turned = Log(pose.pose.Inverse() * fix.pose)(5);
  return turned * turned <= options_.max_squared_heading_distance * heading_variance;
}

bool FixMonitor::IsFusable(Stamp stamp, const PoseEstimate<3>& fix,
                           const PoseEstimate<3>& pose) const {
  if (fused_ && stamp - *fused_ < options_.fusion_interval) return false;
  return HorizontalSigma(fix.covariance) <=
         options_.fusion_sigma_factor * HorizontalSigma(pose.covariance);
}

std::optional<PoseEstimate<3>> CarriedToNow(const PoseEstimate<3>& fix, Stamp stamp,
                                            const std::optional<PoseEstimate<3>>& pose,
                                            const MotionHistory& history,
                                            const FixMonitorOptions& options) {
  if (history.empty()) return fix;
  const std::optional<MotionHistory::Moment> moment = history.AtOrSoonAfter(stamp);
  if (!moment) return std::nullopt;
  PoseEstimate<3> then = fix;
  if (pose) {
    then = WithHeadingOf({.pose = pose->pose * moment->to_newest.T_from_to.Inverse(),
                          .covariance = pose->covariance},
                         fix, options);
  }
  const Motion carried = Compose({then.pose, then.covariance}, moment->to_newest);
  return PoseEstimate<3>{.pose = carried.T_from_to, .covariance = carried.covariance};
}

PoseEstimate<3> PositionOf(const PoseEstimate<3>& fix) {
  PoseEstimate<3> position{.pose = fix.pose, .covariance = kUnknownVariance * Matrix6d::Identity()};
  position.covariance.topLeftCorner<2, 2>() = fix.covariance.topLeftCorner<2, 2>();
  return position;
}

PoseEstimate<3> WithHeadingOf(const PoseEstimate<3>& pose, PoseEstimate<3> fix,
                              const FixMonitorOptions& options) {
  if (std::sqrt(fix.covariance(5, 5)) < options.unknown_heading_sigma_rad) return fix;
  const Eigen::Matrix3d R_pose_fix = pose.pose.Rotation().transpose() * fix.pose.Rotation();
  const Eigen::Matrix3d position = fix.covariance.topLeftCorner<3, 3>();
  fix.pose.rotation = pose.pose.rotation;
  fix.covariance = pose.covariance;
  fix.covariance.topRightCorner<3, 3>().setZero();
  fix.covariance.bottomLeftCorner<3, 3>().setZero();
  fix.covariance.topLeftCorner<3, 3>() = R_pose_fix * position * R_pose_fix.transpose();
  return fix;
}

}  // namespace dcloc
