#include "core/versions/version_score.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace dcloc {
namespace {

constexpr double kReach_m = 1.0;  // beyond it a target fits no landmark
// What a consensus itself errs by, in x, y and yaw.
constexpr double kConsensus_m = 0.02;
constexpr double kConsensus_rad = 0.002;

double QuantileOf(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, at);
  return *at;
}

}  // namespace

FitScorer::FitScorer(std::span<const PlacedLandmark> landmarks) {
  for (const PlacedLandmark& landmark : landmarks) {
    positions_.push_back(landmark.position);
    grid_.Insert(landmark.position.position_m);
  }
}

double FitScorer::Sum(std::span<const RadarPoint> points, const Pose2& T_local_vehicle) const {
  const Eigen::Matrix2d rotation = T_local_vehicle.Rotation();
  double sum = 0.0;
  for (const RadarPoint& point : points) {
    const Eigen::Vector2d p_local = T_local_vehicle * Eigen::Vector2d(point.position_m.head<2>());
    const Eigen::Matrix2d noise =
        rotation * point.covariance_m2.topLeftCorner<2, 2>() * rotation.transpose();
    double best = 0.0;
    grid_.ForEachNear(p_local, Eigen::Vector2d::Constant(kReach_m), [&](std::uint32_t i) {
      const Eigen::Vector2d offset_m = positions_[i].position_m - p_local;
      const Eigen::Matrix2d covariance = positions_[i].covariance_m2 + noise;
      best = std::max(best, std::exp(-0.5 * offset_m.dot(covariance.inverse() * offset_m)));
    });
    sum += best;
  }
  return sum;
}

void ScoreSum::AddTracking(bool is_tracking) {
  ++scan_count_;
  if (is_tracking) ++tracking_count_;
}

void ScoreSum::Add(const ReplayedScan& scan, const Pose2& T_map_consensus) {
  AddTracking(scan.is_tracking);
  if (!scan.is_tracking) return;
  const Pose2 T_vehicle_consensus = scan.T_map_vehicle.Inverse() * T_map_consensus;
  errors_m_.push_back(T_vehicle_consensus.translation_m.norm());
  Eigen::Vector3d error;
  error << T_vehicle_consensus.translation_m, WrapAngle(T_vehicle_consensus.yaw_rad);
  Eigen::Matrix3d covariance = scan.covariance;
  covariance.diagonal() += Eigen::Vector3d(kConsensus_m * kConsensus_m, kConsensus_m * kConsensus_m,
                                           kConsensus_rad * kConsensus_rad);
  nees_.push_back(error.dot(covariance.inverse() * error) / 3.0);
}

void ScoreSum::AddOffset(const Pose2& T_old_version) {
  offsets_m_.push_back(T_old_version.translation_m.norm());
}

void ScoreSum::AddFit(double sum, std::size_t point_count) {
  fit_ += sum;
  point_count_ += point_count;
}

VersionScore ScoreSum::Score() const {
  const auto share = [](double part, std::size_t whole) {
    return whole == 0 ? 0.0 : part / static_cast<double>(whole);
  };
  return {.error_m = QuantileOf(errors_m_, 0.5),
          .error_p90_m = QuantileOf(errors_m_, 0.9),
          .offset_m = QuantileOf(offsets_m_, 0.5),
          .tracking_share = share(static_cast<double>(tracking_count_), scan_count_),
          .nees = QuantileOf(nees_, 0.5),
          .fit = share(fit_, point_count_)};
}

}  // namespace dcloc
