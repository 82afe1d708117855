#pragma once

#include <grpcpp/server_builder.h>

#include "server/config/config.h"
#include "server/net/listener.h"

namespace dcloc::server {

/// Limits of messages, streams and idle connections, keepalive, and what is done to all calls.
void SetUpTransport(const ServerConfig& config, grpc::ServerBuilder& builder);

/// How many connections there may be. Warns if they are fewer than the sessions.
Listener::Bounds ConnectionBounds(const ServerConfig& config);

}  // namespace dcloc::server
