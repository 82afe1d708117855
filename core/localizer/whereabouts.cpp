#include "core/localizer/whereabouts.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/geometry/covariance.h"

namespace dcloc {
namespace {

constexpr double kSigmas = 3.0;
constexpr double kMaxRadius_m = 150.0;  // wider ones are searched with the whole map

double LargestSigma(const Matrix6d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(covariance.topLeftCorner<2, 2>(),
                                                              Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues()(1)));
}

}  // namespace

void Whereabouts::Set(const PoseEstimate<3>& T_map_vehicle) {
  now_ = T_map_vehicle;
  known_sigma_m_ = LargestSigma(T_map_vehicle.covariance);
  way_m_ = 0.0;
}

void Whereabouts::OnMotion(const Motion& motion) {
  if (!now_) return;
  now_ = {
      .pose = now_->pose * motion.T_from_to,
      .covariance = ComposeCovariance<3>(now_->covariance, motion.T_from_to, motion.covariance)};
  way_m_ += motion.T_from_to.translation_m.norm();
}

bool Whereabouts::IsPrediction(const Matrix6d& covariance) const {
  return std::sqrt(covariance.topLeftCorner<2, 2>().trace()) <= options_.max_prior_sigma_m &&
         std::sqrt(covariance(5, 5)) <= options_.max_prior_sigma_rad;
}

std::optional<PlaceRegion> Whereabouts::Region() const {
  if (!now_) return std::nullopt;
  // However little is known of the heading, it is no further off than there and back.
  const double radius_m =
      std::min(kSigmas * LargestSigma(now_->covariance), kSigmas * known_sigma_m_ + 2.0 * way_m_);
  if (radius_m > kMaxRadius_m) return std::nullopt;
  return PlaceRegion{.centre_m = now_->pose.translation_m.head<2>(),
                     .radius_m = radius_m,
                     .yaw_rad = Yaw(now_->pose.rotation),
                     .yaw_reach_rad = kSigmas * std::sqrt(now_->covariance(5, 5))};
}

}  // namespace dcloc
