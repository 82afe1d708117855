#pragma once

#include <grpcpp/support/status.h>

#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace dcloc::server {

/// The gRPC status of the same code and message; without memory for that, of `OutOfMemory`.
grpc::Status ToGrpc(const absl::Status& status) noexcept;

/// Text that a client sent, made safe for a message or a log line: quoted, escaped, and truncated
/// when long.
std::string Quoted(absl::string_view text);

/// `status` with `prefix` before its message; OK stays OK.
absl::Status WithPrefix(absl::string_view prefix, const absl::Status& status);

}  // namespace dcloc::server
