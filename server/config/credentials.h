#pragma once

#include <grpcpp/security/server_credentials.h>

#include <memory>

#include "absl/status/statusor.h"
#include "server/config/config.h"
#include "server/config/served_certificates.h"
#include "server/net/call_gate.h"

namespace dcloc::server {

/// What a server listens with.
struct Credentials {
  std::shared_ptr<grpc::ServerCredentials> credentials;
  std::shared_ptr<ServedCertificates> certificates;  ///< of TLS; null in plaintext
};

/// TLS with the configured files, if there are any, else plaintext. New connections get the
/// certificates that are shown at their time; clients must have one too if there is an authority
/// for them. Each call goes through `gate`. Both outlive the server. InvalidArgument for files that
/// TLS does not work with, and for plaintext on an address that other machines can reach, unless
/// `allow_plaintext_off_loopback` is set.
absl::StatusOr<Credentials> MakeCredentials(const ServerConfig& config,
                                            std::shared_ptr<CallGate> gate);

}  // namespace dcloc::server
