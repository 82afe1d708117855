#pragma once

#include <grpcpp/security/server_credentials.h>

#include <memory>

#include "absl/status/statusor.h"
#include "server/config/config.h"

namespace dcloc::server {

/// What the server speaks: TLS from the configured files, which are read again when they change,
/// with client certificates where an authority for them is given; else plaintext. InvalidArgument
/// for plaintext on an address that other machines can reach, unless that is allowed by name, and
/// for files that do not make up a key and its certificate.
absl::StatusOr<std::shared_ptr<grpc::ServerCredentials>> MakeCredentials(
    const ServerConfig& config);

}  // namespace dcloc::server
