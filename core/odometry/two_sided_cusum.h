#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include "absl/status/status.h"
#include "core/odometry/scalar_estimate.h"
#include "core/options/option_fields.h"

namespace dcloc {

/// When a mean is said to have changed (Page 1954): each deviation beyond `drift_sigmas` counts,
/// up to `max_sigmas`, until `limit_sigmas` are exceeded or the sum falls below 0.
struct TwoSidedCusumOptions {
  double drift_sigmas = 1.0;
  double max_sigmas = 3.0;
  double limit_sigmas = 4.0;
};
std::span<const OptionField<TwoSidedCusumOptions>> FieldsOf(const TwoSidedCusumOptions& options);
absl::Status Validate(const TwoSidedCusumOptions& options);

/// Finds that a quantity which is expected to be 0 has changed for good, to either side: sums of
/// its deviations, none of which counts much alone. Where they scatter by more than their variance,
/// they are scaled down. The scatter is measured on differences of neighbouring deviations, to
/// which a change contributes only once.
class TwoSidedCusum {
 public:
  explicit TwoSidedCusum(const TwoSidedCusumOptions& options) : options_(options) {}

  /// A deviation from 0 that came about over `exposure`, a time or a distance. Gives the deviation
  /// per unit of exposure since the change, and its variance, once there is one; the test then
  /// begins anew.
  std::optional<ScalarEstimate> OnDeviation(const ScalarEstimate& deviation, double exposure);

  /// The deviation per unit of exposure that is suspected: there is no change yet, but the sum has
  /// reached half of `limit_sigmas`.
  std::optional<double> UnconfirmedChange() const;

  void Reset() { rising_ = falling_ = {}; }

 private:
  struct Side {
    double sum_sigmas = 0.0;
    // Since the sum last was 0.
    double deviation = 0.0;
    double variance = 0.0;
    double exposure = 0.0;
  };
  bool Count(double sigmas, const ScalarEstimate& deviation, double exposure, Side& side) const;

  double SpreadWith(double sigmas);

  TwoSidedCusumOptions options_;
  static constexpr std::size_t kDifferences = 5;
  std::array<double, kDifferences> differences_{};  // of neighbouring deviations, in sigmas
  std::size_t difference_count_ = 0;                // ever
  std::optional<double> last_sigmas_;
  Side rising_, falling_;
};

}  // namespace dcloc
