#include "core/odometry/two_sided_cusum.h"

#include <algorithm>
#include <cmath>

namespace dcloc {

std::span<const OptionField<TwoSidedCusumOptions>> FieldsOf(
    const TwoSidedCusumOptions& /*options*/) {
  using O = TwoSidedCusumOptions;
  static constexpr OptionField<O> kFields[] = {
      {"drift_sigmas", &O::drift_sigmas, 0, 1000, "each deviation counts"},
      {"max_sigmas", &O::max_sigmas, 1e-3, 1e6},
      {"limit_sigmas", &O::limit_sigmas, 0, 1e6, "a single deviation is a change"},
  };
  return kFields;
}

absl::Status Validate(const TwoSidedCusumOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

std::optional<ScalarEstimate> TwoSidedCusum::OnDeviation(const ScalarEstimate& deviation,
                                                         double exposure) {
  if (exposure <= 0.0) return std::nullopt;
  const double stated = deviation.value / std::sqrt(deviation.variance);
  const double sigmas =
      std::clamp(stated / SpreadWith(stated), -options_.max_sigmas, options_.max_sigmas);
  const bool rose = Count(sigmas, deviation, exposure, rising_);
  const bool fell = Count(-sigmas, deviation, exposure, falling_);
  if (!rose && !fell) return std::nullopt;
  const Side& side = rose ? rising_ : falling_;
  const ScalarEstimate change{side.deviation / side.exposure,
                              side.variance / (side.exposure * side.exposure)};
  Reset();
  return change;
}

std::optional<double> TwoSidedCusum::UnconfirmedChange() const {
  const Side& side = rising_.sum_sigmas > falling_.sum_sigmas ? rising_ : falling_;
  if (2.0 * side.sum_sigmas <= options_.limit_sigmas) return std::nullopt;
  return side.deviation / side.exposure;
}

// By how much deviations vary more than they say, at least 1: by the median of the last differences
// between neighbours, of which a change makes one large.
double TwoSidedCusum::SpreadWith(double sigmas) {
  if (last_sigmas_) {
    differences_[difference_count_++ % kDifferences] = std::abs(sigmas - *last_sigmas_);
  }
  last_sigmas_ = sigmas;
  std::array<double, kDifferences> sorted = differences_;
  std::ranges::sort(sorted);
  constexpr double kMedianOfUnitNormal = 0.6745;
  return std::max(1.0, sorted[kDifferences / 2] / (std::sqrt(2.0) * kMedianOfUnitNormal));
}

bool TwoSidedCusum::Count(double sigmas, const ScalarEstimate& deviation, double exposure,
                          Side& side) const {
  side.sum_sigmas += sigmas - options_.drift_sigmas;
  if (side.sum_sigmas <= 0.0) {
    side = {};
    return false;
  }
  side.deviation += deviation.value;
  side.variance += deviation.variance;
  side.exposure += exposure;
  return side.sum_sigmas > options_.limit_sigmas;
}

}  // namespace dcloc
