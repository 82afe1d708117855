#pragma once

#include "absl/strings/string_view.h"

namespace dcloc::server {

/// Whether `text` is a HOST:PORT, "[V6]:PORT" among them, and nothing else that a channel would
/// take for a target: no scheme, no path, no list. Callers' tokens go there.
bool IsReplicaAddress(absl::string_view text);

}  // namespace dcloc::server
