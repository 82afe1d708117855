#pragma once

#include <span>

#include "server/identity/role.h"

namespace dcloc::server {

/// What an RPC does to others.
enum class Effect {
  kReads,    ///< nothing that others notice
  kChanges,  ///< something that is to be known afterwards: `OperationLog` keeps it
};

/// The permission that one RPC needs.
struct MethodPermission {
  const char* method;  ///< full name, "dcloc.v1.MapService.ListMaps"
  Permission permission;
  Effect effect = Effect::kReads;
};

/// The table of all RPCs of dcloc.v1, each once. An RPC that is not in it is refused; a test
/// compares the table with the services of the server. `grpc.health.v1` and reflection are open to
/// everyone: probes have no identity, and the contract is public.
std::span<const MethodPermission> MethodPermissions();

}  // namespace dcloc::server
