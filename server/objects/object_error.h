#pragma once

#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace dcloc::server {

/// What a client is told when the object store does not do what it should: nothing of where it is,
/// but what to do.
inline constexpr char kObjectStoreIsAway[] =
    "the store of map files cannot be reached; try again in a few seconds";

/// Unavailable with `kObjectStoreIsAway`, and the reason beside it for the log
/// (`ObjectStoreReason`).
absl::Status ObjectStoreError(absl::string_view reason);

/// Whether an error is one of an object store that is away, or that refuses this server.
bool IsObjectStoreError(const absl::Status& status);

/// Why; the message of any other error.
std::string ObjectStoreReason(const absl::Status& status);

}  // namespace dcloc::server
