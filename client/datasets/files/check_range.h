#pragma once

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace dcloc {

/// OK when `value` lies in [min, max]. Otherwise, and for NaN, InvalidArgument that names `field`,
/// the value and the bounds.
absl::Status CheckRange(absl::string_view field, double value, double min, double max);

}  // namespace dcloc
