#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "server/config/config.h"
#include "server/maps/store/map_store.h"
#include "server/replicas/replica_channels.h"
#include "server/sessions/session_registry.h"
#include "server/tickets/session_tickets.h"

/// What the parts of a server are made with, out of its settings.
namespace dcloc::server {

/// Threads that localize scans; as many more do so for whom it takes long.
int WorkerCount(const ServerConfig& config);

SessionTimeouts SessionTimeoutsOf(const ServerConfig& config);

MapStoreOptions MapStoreOptionsOf(const ServerConfig& config);

/// Null where no fleet keys are configured. InvalidArgument says what is wrong with their file.
absl::StatusOr<std::unique_ptr<SessionTickets>> TicketsOf(const ServerConfig& config);

/// How this server calls others.
ReplicaTls ReplicaTlsOf(const ServerConfig& config);

/// HOST:PORT by which others reach a server that listens on `port`. InvalidArgument names
/// `replica_address`.
absl::StatusOr<std::string> ReplicaAddressOf(const ServerConfig& config, int port);

}  // namespace dcloc::server
