#pragma once

#include <chrono>

#include "absl/status/status.h"
#include "server/net/listen_address.h"

namespace dcloc::server {

/// Makes a new connection to a gRPC server on this machine and waits for its first bytes: with TLS
/// until a handshake is answered, in plaintext until HTTP/2's first frame comes. So it
/// distinguishes a server that accepts connections from one where only the kernel does. A wildcard
/// address is reached by loopback. Unavailable or DeadlineExceeded says what did not come.
absl::Status ProbeListener(const ListenAddress& address, bool tls,
                           std::chrono::milliseconds timeout);

}  // namespace dcloc::server
