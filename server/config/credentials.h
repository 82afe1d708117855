#pragma once

#include <grpcpp/security/server_credentials.h>

#include <memory>

#include "absl/status/statusor.h"
#include "server/config/config.h"

namespace dcloc::server {

/// The server's credentials. TLS with the configured files, which are read again when they change,
/// and with client certificates if an authority for them is given; without files plaintext.
/// InvalidArgument for plaintext on an address that other machines can reach, unless
/// `allow_plaintext_off_loopback` is set, and for files that are not a key and its certificate.
absl::StatusOr<std::shared_ptr<grpc::ServerCredentials>> MakeCredentials(
    const ServerConfig& config);

}  // namespace dcloc::server
