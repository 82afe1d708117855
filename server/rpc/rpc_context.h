#pragma once

#include "server/base/open_calls.h"
#include "server/base/peer_wait.h"
#include "server/base/worker_pool.h"
#include "server/config/limits.h"
#include "server/identity/access_control.h"
#include "server/identity/operation_log.h"
#include "server/maps/store/map_store.h"
#include "server/net/awaited_requests.h"

namespace dcloc::server {

/// What calls that use the store share; outlives them.
struct RpcContext {
  MapStore& store;
  WorkerPool& pool;  ///< for all that may wait for a disk
  OpenCalls& open_calls;
  PeerBoundCalls& peer_bound_calls;
  AwaitedRequests& awaited_requests;
  const AccessControl& access;
  OperationLog& operations;
  const Limits& limits;
};

}  // namespace dcloc::server
