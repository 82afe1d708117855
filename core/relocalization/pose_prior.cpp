#include "core/relocalization/pose_prior.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/geometry/covariance.h"

namespace dcloc {
namespace {

double LargestSigma(const Matrix6d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(covariance.topLeftCorner<2, 2>(),
                                                              Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues()(1)));
}

}  // namespace

std::span<const OptionField<PosePriorOptions>> FieldsOf(const PosePriorOptions& /*options*/) {
  using O = PosePriorOptions;
  static constexpr OptionField<O> kFields[] = {
      {"max_prediction_sigma_m", &O::max_prediction_sigma_m, 0, 100, "every prior is searched for"},
      {"max_prediction_sigma_rad", &O::max_prediction_sigma_rad, 0, 10,
       "every prior is searched for"},
      {"region_sigmas", &O::region_sigmas, 1e-6, 100},
      {"max_region_radius_m", &O::max_region_radius_m, 0, 1e6,
       "every prior is searched with the whole map"},
      {"region_growth_m", &O::region_growth_m, 0, 1000, "a region grows by its own size alone"},
      {"region_growth_factor", &O::region_growth_factor, 1, 1000},
  };
  return kFields;
}

absl::Status Validate(const PosePriorOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

void PosePrior::Set(const PoseEstimate<3>& T_map_vehicle) {
  now_ = then_ = T_map_vehicle;
  since_then_ = {};
}

void PosePrior::OnMotion(const Motion& motion) {
  if (!now_) return;
  now_ = {
      .pose = now_->pose * motion.T_from_to,
      .covariance = ComposeCovariance<3>(now_->covariance, motion.T_from_to, motion.covariance)};
  since_then_ = Compose(since_then_, motion);
}

bool PosePrior::IsPrediction(const Matrix6d& covariance) const {
  return HorizontalSigma(covariance) <= options_.max_prediction_sigma_m &&
         std::sqrt(covariance(5, 5)) <= options_.max_prediction_sigma_rad;
}

std::optional<SearchRegion> PosePrior::Region(int failed_search_count, double min_radius_m) const {
  if (!now_) return std::nullopt;
  double radius_m = options_.region_sigmas * std::hypot(LargestSigma(then_.covariance),
                                                        LargestSigma(since_then_.covariance));
  double max_yaw_offset_rad =
      options_.region_sigmas * std::sqrt(then_.covariance(5, 5) + since_then_.covariance(5, 5));
  if (failed_search_count > 0) {
    radius_m = (radius_m + options_.region_growth_m) *
               std::pow(options_.region_growth_factor, failed_search_count);
    max_yaw_offset_rad = std::numbers::pi;
  }
  const int growth_of_min = std::max(0, failed_search_count - 1);
  radius_m =
      std::max(radius_m, min_radius_m * std::pow(options_.region_growth_factor, growth_of_min));
  // Written so that a radius that is not a number is no region.
  if (!(radius_m <= options_.max_region_radius_m)) return std::nullopt;
  return SearchRegion{.centre_m = then_.pose.translation_m.head<2>(),
                      .radius_m = radius_m,
                      .yaw_rad = Yaw(then_.pose.rotation),
                      .max_yaw_offset_rad = max_yaw_offset_rad,
                      .T_then_now = Flatten(since_then_.T_from_to)};
}

}  // namespace dcloc
