#pragma once

#include <span>

#include "server/identity/role.h"

namespace dcloc::server {

/// What one RPC needs.
struct MethodPermission {
  const char* method;  ///< full name, "dcloc.v1.MapService.ListMaps"
  Permission permission;
};

/// Every RPC of ours, once. An RPC that is not in it is refused; a test holds the table against the
/// services that are served. `grpc.health.v1` and reflection are open to everyone: probes have no
/// identity, and the contract is no secret.
std::span<const MethodPermission> MethodPermissions();

}  // namespace dcloc::server
