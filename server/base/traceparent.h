#pragma once

#include <grpcpp/server_context.h>

#include <string>

#include "absl/strings/string_view.h"

namespace dcloc::server {

/// The trace id (32 hexadecimal digits) of a W3C `traceparent`, empty when it is malformed. As the
/// W3C recommendation demands, a malformed one is ignored and is no error of the call.
std::string TraceIdOf(absl::string_view traceparent);

/// The same of a call's metadata.
std::string TraceIdOf(const grpc::ServerContextBase& context);

}  // namespace dcloc::server
