#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "client/sdk/channel.h"

namespace dcloc::cli {

/// What a TLS handshake with a server showed. Nothing is sent but the handshake.
struct TlsProbe {
  std::string fault;              ///< why the certificate is not trusted; empty where it is
  std::string expected_name;      ///< the name that it was held against
  std::string names;              ///< those that the certificate is for
  std::int64_t not_before_s = 0;  ///< since 1970
  std::int64_t not_after_s = 0;
  bool asks_for_certificate = false;  ///< the server wants to see the client's
};

/// Whether a TCP connection to "HOST:PORT" comes about. NotFound for a host without address,
/// Unavailable or DeadlineExceeded otherwise; errors name the address.
absl::Status ProbeTcp(const std::string& server, std::chrono::milliseconds timeout);

/// Shakes hands as `options` say; without `tls_ca` no certificate is trusted. Errors of the
/// connection as of `ProbeTcp`; FailedPrecondition where the server speaks no TLS; InvalidArgument
/// for files that cannot be used.
absl::StatusOr<TlsProbe> ProbeTls(const client::ChannelOptions& options,
                                  std::chrono::milliseconds timeout);

}  // namespace dcloc::cli
