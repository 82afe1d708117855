#pragma once

#include "absl/status/status.h"

namespace dcloc {

/// Whether a call ended like this because its server was killed.
inline bool IsGone(const absl::Status& status) {
  return absl::IsUnavailable(status) || absl::IsCancelled(status);
}

}  // namespace dcloc
