#pragma once

#include <grpcpp/support/client_interceptor.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace dcloc::client {

/// The token in a file, without the line end that editors and `dcloc-server token create` leave. An
/// error names the file, never its contents.
absl::StatusOr<std::string> ReadToken(const std::string& path);

/// Whether HOST is this machine: "localhost", 127.0.0.0/8 or ::1.
bool IsLoopback(absl::string_view host);

using Interceptors =
    std::vector<std::unique_ptr<grpc::experimental::ClientInterceptorFactoryInterface>>;

/// The headers that each call of a channel is sent with, by their keys.
using Headers = std::map<std::string, std::string>;

/// The proof of who has `token`.
inline Headers::value_type ProofOf(const std::string& token) {
  return {"authorization", "Bearer " + token};
}

/// What sends `headers`, which are not empty, with each call of a channel.
Interceptors SendHeaders(Headers headers);

}  // namespace dcloc::client
