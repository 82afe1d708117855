#include "client/datasets/files/check_range.h"

#include "absl/strings/str_format.h"

namespace dcloc {

absl::Status CheckRange(absl::string_view field, double value, double min, double max) {
  if (value >= min && value <= max) return absl::OkStatus();  // false for NaN
  return absl::InvalidArgumentError(
      absl::StrFormat("%s is %g; it must lie in [%g, %g]", field, value, min, max));
}

}  // namespace dcloc
