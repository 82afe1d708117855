#include "core/passes/scan_worth.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace dcloc {
namespace {

/// What is wrong with the sources that the pose and the scan of `radar` rest on; kNone for nothing.
SourceFault FaultOf(const Health& health, std::size_t radar) {
  for (const SourceHealth& source : {health.wheel_speed, health.yaw_rate}) {
    if (!source.is_used && source.fault != SourceFault::kSilent) return source.fault;
  }
  return health.radars[radar].is_used ? SourceFault::kNone : health.radars[radar].fault;
}

}  // namespace

double HorizontalSigma_m(const Matrix6d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(
      Eigen::Matrix2d(covariance.topLeftCorner<2, 2>()), Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues().y()));
}

ScanWorth ScanJudge::Judge(const Localization& answer, std::size_t radar, Stamp stamp) {
  if (answer.state != LocalizationState::kTracking) {
    tracking_since_.reset();
  } else if (!tracking_since_) {
    tracking_since_ = stamp;
  }
  if (!tracking_since_ || stamp - *tracking_since_ < options_.settle) return ScanWorth::kUntracked;
  const SourceFault fault = FaultOf(answer.health, radar);
  if (fault != SourceFault::kNone) {
    fault_ = fault;
    return ScanWorth::kUnsound;
  }
  const bool is_sure = HorizontalSigma_m(answer.covariance) <= options_.max_sigma_m &&
                       answer.quality.inlier_count >= options_.min_inlier_count;
  return is_sure ? ScanWorth::kGood : ScanWorth::kUnsure;
}

}  // namespace dcloc
