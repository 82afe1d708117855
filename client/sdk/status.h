#pragma once

#include <grpcpp/support/status.h>

#include "absl/status/status.h"

namespace dcloc::client {

/// The same status: gRPC's codes are absl's.
absl::Status FromGrpc(const grpc::Status& status);

}  // namespace dcloc::client
