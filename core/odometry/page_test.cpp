#include "core/odometry/page_test.h"

#include <algorithm>
#include <cmath>

namespace dcloc {

std::span<const OptionField<PageTestOptions>> FieldsOf(const PageTestOptions& /*options*/) {
  using O = PageTestOptions;
  static constexpr OptionField<O> kFields[] = {
      {"drift_sigmas", &O::drift_sigmas, 0, 1000, "each deviation counts"},
      {"max_sigmas", &O::max_sigmas, 1e-3, 1e6},
      {"limit_sigmas", &O::limit_sigmas, 0, 1e6, "a single deviation is a change"},
  };
  return kFields;
}

absl::Status Validate(const PageTestOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

std::optional<ScalarEstimate> PageTest::OnDeviation(const ScalarEstimate& deviation,
                                                    double exposure) {
  if (exposure <= 0.0) return std::nullopt;
  const double sigmas = std::clamp(deviation.value / std::sqrt(deviation.variance),
                                   -options_.max_sigmas, options_.max_sigmas);
  const bool rose = Count(sigmas, deviation, exposure, rising_);
  const bool fell = Count(-sigmas, deviation, exposure, falling_);
  if (!rose && !fell) return std::nullopt;
  const Side& side = rose ? rising_ : falling_;
  const ScalarEstimate change{side.deviation / side.exposure,
                              side.variance / (side.exposure * side.exposure)};
  Reset();
  return change;
}

bool PageTest::Count(double sigmas, const ScalarEstimate& deviation, double exposure,
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
