#pragma once

#include <chrono>
#include <span>
#include <variant>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace dcloc {

/// One field of an options struct and the values that it may have, [min, max]. Those of a duration
/// are milliseconds.
template <typename Options>
struct OptionField {
  const char* name;
  std::variant<double Options::*, int Options::*, std::chrono::nanoseconds Options::*> member;
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
  static double AsNumber(std::chrono::nanoseconds value) {
    return std::chrono::duration<double, std::milli>(value).count();
  }
};

/// OK, or InvalidArgument that names the first field that lies outside of its bounds, its value and
/// the bounds; NaN does.
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

/// `status` of options that are the member `group` of others: its message names the field in full.
inline absl::Status Within(const char* group, const absl::Status& status) {
  if (status.ok()) return status;
  return absl::Status(status.code(), absl::StrCat(group, ".", status.message()));
}

}  // namespace dcloc
