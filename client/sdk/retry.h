#pragma once

#include "absl/status/status.h"

namespace dcloc::client {

/// Whether another attempt may do better than a stream that ended so. Before it was open the server
/// may just have been full; after that, what exhausted it is what was sent.
inline bool IsRetryable(const absl::Status& status, bool was_open) {
  switch (status.code()) {
    case absl::StatusCode::kOk:
    case absl::StatusCode::kUnavailable:
    case absl::StatusCode::kCancelled:
    case absl::StatusCode::kUnknown:
    case absl::StatusCode::kInternal:
    case absl::StatusCode::kDeadlineExceeded:
      return true;
    case absl::StatusCode::kResourceExhausted:
      return !was_open;
    default:
      return false;
  }
}

}  // namespace dcloc::client
