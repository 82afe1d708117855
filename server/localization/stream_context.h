#pragma once

#include "server/identity/usage.h"
#include "server/rpc/rpc_context.h"
#include "server/sessions/open_session.h"
#include "server/sessions/session_registry.h"

namespace dcloc::server {

/// What all streams share; outlives them.
struct StreamContext {
  const RpcContext& storage;  ///< opening a session may wait for a disk
  SessionRegistry& registry;
  SessionSources sessions;
  UsageCounts& usages;
  int max_pending_scan_count;  ///< per session
};

}  // namespace dcloc::server
