#pragma once

#include <grpcpp/support/status.h>

#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace dcloc::server {

/// The same status for the wire: absl's codes are gRPC's.
grpc::Status ToGrpc(const absl::Status& status);

/// What a client sent, fit for a message or a log line: in quotes, escaped, and cut when long.
std::string Quoted(absl::string_view text);

/// `status` with `prefix` before its message; OK stays OK.
absl::Status WithPrefix(absl::string_view prefix, const absl::Status& status);

}  // namespace dcloc::server
