#pragma once

#include "absl/status/status.h"
#include "absl/strings/str_format.h"

namespace dcloc {

/// The error of a file that is not as its format asks.
template <typename... Args>
absl::Status DataLoss(const absl::FormatSpec<Args...>& format, const Args&... args) {
  return absl::DataLossError(absl::StrFormat(format, args...));
}

}  // namespace dcloc
