#pragma once

#include <chrono>
#include <cstddef>
#include <span>
#include <variant>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace dcloc {

/// One number of an options struct and its bounds, [min, max]. The bounds of a duration are in
/// milliseconds.
template <typename Options>
struct OptionField {
  const char* name;
  std::variant<double Options::*, int Options::*, std::size_t Options::*,
               std::chrono::nanoseconds Options::*>
      member;
  double min;
  double max;
  /// What zero means, where it lies in [min, max].
  const char* zero = "";

  double ValueIn(const Options& options) const {
    return std::visit([&](auto pointer) { return AsNumber(options.*pointer); }, member);
  }

 private:
  static double AsNumber(double value) { return value; }
  static double AsNumber(int value) { return value; }
  static double AsNumber(std::size_t value) { return static_cast<double>(value); }
  static double AsNumber(std::chrono::nanoseconds value) {
    return std::chrono::duration<double, std::milli>(value).count();
  }
};

/// OK, or InvalidArgument that names the first field outside of its bounds, its value and the
/// bounds. NaN is outside of all bounds.
template <typename Options>
absl::Status ValidateFields(const Options& options, std::span<const OptionField<Options>> fields) {
  for (const OptionField<Options>& field : fields) {
    const double value = field.ValueIn(options);
    if (value >= field.min && value <= field.max) continue;
    return absl::InvalidArgumentError(absl::StrFormat("%s is %g; it must lie in [%g, %g]",
                                                      field.name, value, field.min, field.max));
  }
  return absl::OkStatus();
}

/// The status of options that are a member of other options. The message gets the member's name,
/// `group`, in front of the field.
inline absl::Status Within(const char* group, const absl::Status& status) {
  if (status.ok()) return status;
  return absl::Status(status.code(), absl::StrCat(group, ".", status.message()));
}

}  // namespace dcloc
