#pragma once

#include <chrono>

#include "absl/status/status.h"
#include "server/net/listen_address.h"

namespace dcloc::server {

/// Makes a new connection to a gRPC server on this machine and asks `grpc.health.v1` over it, in
/// plaintext or TLS, until the first bytes of an answer come, whatever it says. So it distinguishes
/// a server that answers calls from one that only accepts connections, and from one where only the
/// kernel does. With TLS a server that wants a certificate, and says so, has answered. A wildcard
/// address is reached by loopback. Unavailable or DeadlineExceeded says what did not come.
absl::Status ProbeListener(const ListenAddress& address, bool tls,
                           std::chrono::milliseconds timeout);

}  // namespace dcloc::server
