#pragma once

#include <algorithm>
#include <span>

#include "absl/status/status.h"
#include "core/options/option_fields.h"

namespace dcloc {

/// When deviations that each say little have said enough. All in standard deviations.
struct OneSidedCusumOptions {
  double drift = 2.0;   ///< each deviation counts by what it exceeds this
  double max = 4.0;     ///< and counts no more than this
  double limit = 10.0;  ///< the sum at which they have said enough
};
std::span<const OptionField<OneSidedCusumOptions>> FieldsOf(const OneSidedCusumOptions& options);
absl::Status Validate(const OneSidedCusumOptions& options);

/// A one-sided cumulative sum with hysteresis (Page, "Continuous Inspection Schemes", 1954; METHOD
/// eq 59).
class OneSidedCusum {
 public:
  /// Takes in a deviation, in standard deviations.
  void Add(double deviation, const OneSidedCusumOptions& options) {
    sum_ = std::clamp(sum_ + std::min(deviation, options.max) - options.drift, 0.0, options.limit);
    if (sum_ >= options.limit) is_exceeded_ = true;
    if (has_eased(options)) is_exceeded_ = false;
  }

  /// Whether the sum has reached the limit, and has not fallen to half of it since.
  bool is_exceeded() const { return is_exceeded_; }

  /// Whether the sum is at most half the limit.
  bool has_eased(const OneSidedCusumOptions& options) const { return sum_ <= 0.5 * options.limit; }

  /// What deviations have said so far, from 0 to the limit.
  double sum() const { return sum_; }

 private:
  double sum_ = 0.0;
  bool is_exceeded_ = false;
};

}  // namespace dcloc
