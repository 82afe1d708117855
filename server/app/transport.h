#pragma once

#include <grpcpp/server_builder.h>

#include "server/config/config.h"
#include "server/net/bounded_calls.h"
#include "server/net/listener.h"

namespace dcloc::server {

/// Limits of messages, streams, threads and idle connections, keepalive, and what is done to all
/// calls. `calls` outlives the server.
void SetUpTransport(const ServerConfig& config, BoundedCalls& calls, grpc::ServerBuilder& builder);

/// How many connections there may be. Warns if they are fewer than the sessions.
Listener::Bounds ConnectionBounds(const ServerConfig& config);

}  // namespace dcloc::server
