#include "core/uncertainty/protection_level.h"

#include <algorithm>
#include <cmath>

namespace dcloc {

std::span<const OptionField<ProtectionLevelOptions>> FieldsOf(
    const ProtectionLevelOptions& /*options*/) {
  using O = ProtectionLevelOptions;
  static constexpr OptionField<O> kFields[] = {
      {"sigmas", &O::sigmas, 1, 100},
      {"floor_m", &O::floor_m, 0, 100, "the covariance is all that is unknown"},
      {"forgetting_factor", &O::forgetting_factor, 0, 0.999, "the newest innovation counts alone"},
      {"max_squared_sigmas", &O::max_squared_sigmas, 1, 1e6},
      {"max_contradiction_m", &O::max_contradiction_m, 0, 1e6, "a pose that is moved is believed"},
      {"contradiction_fades_m", &O::contradiction_fades_m, 1e-3, 1e6},
  };
  return kFields;
}

absl::Status Validate(const ProtectionLevelOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

void ProtectionLevel::OnInnovation(double squared_distance_per_dof,
                                   const Eigen::Vector2d& residual_m) {
  const double counted = std::min(squared_distance_per_dof, options_.max_squared_sigmas);
  mean_nis_ = options_.forgetting_factor * mean_nis_ + (1.0 - options_.forgetting_factor) * counted;
  mean_residual_m_ = options_.forgetting_factor * mean_residual_m_ +
                     (1.0 - options_.forgetting_factor) * residual_m;
}

void ProtectionLevel::OnContradiction(double distance_m) {
  contradiction_m_ = std::min(contradiction_m_ + distance_m, options_.max_contradiction_m);
}

void ProtectionLevel::OnMotion(double distance_m) {
  contradiction_m_ *= std::exp(-distance_m / options_.contradiction_fades_m);
}

double ProtectionLevel::Of(const Matrix6d& covariance, double bias_m) const {
  return options_.floor_m + bias_m + contradiction_m_ + mean_residual_m_.norm() +
         Spread_m(covariance) * std::sqrt(std::max(1.0, mean_nis_));
}

double ProtectionLevel::Usual(const Matrix6d& covariance) const {
  return options_.floor_m + Spread_m(covariance);
}

double ProtectionLevel::Spread_m(const Matrix6d& covariance) const {
  const double xx = covariance(0, 0);
  const double yy = covariance(1, 1);
  const double greatest_variance_m2 = 0.5 * (xx + yy + std::hypot(xx - yy, 2.0 * covariance(0, 1)));
  return options_.sigmas * std::sqrt(greatest_variance_m2);
}

}  // namespace dcloc
