#pragma once

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace dcloc::server {

/// OK when `value` lies in [min, max], which NaN does not; else InvalidArgument naming `field`, the
/// value and the bounds.
absl::Status CheckBetween(absl::string_view field, double value, double min, double max);

/// The same for integers.
absl::Status CheckIntegerBetween(absl::string_view field, long long value, long long min,
                                 long long max);

/// OK for 1 to 64 of A-Z, a-z, 0-9, '.', '_', ':' and '-': text that needs no quoting in logs and
/// lists.
absl::Status CheckId(absl::string_view field, absl::string_view id);

/// OK for 1 to 63 of a-z, 0-9, '-' and '_', the first one a letter or a digit.
absl::Status CheckMapName(absl::string_view field, absl::string_view name);

/// "`field` is missing".
absl::Status Missing(absl::string_view field);

}  // namespace dcloc::server
