#pragma once

#include "absl/status/status.h"
#include "absl/strings/str_format.h"

namespace dcloc {

/// The error for a file that violates its format.
template <typename... Args>
absl::Status DataLoss(const absl::FormatSpec<Args...>& format, const Args&... args) {
  return absl::DataLossError(absl::StrFormat(format, args...));
}

}  // namespace dcloc
