#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace dcloc::server {

/// So many random bits, a multiple of 8 and at most 256, in hexadecimal. Of 64 bits no two are
/// alike; 128 cannot be guessed. Internal names `what` it is for, where there are no random bytes.
absl::StatusOr<std::string> RandomName(int bits, absl::string_view what);

}  // namespace dcloc::server
