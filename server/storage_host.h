#pragma once

#include "server/identity/access_control.h"
#include "server/limits/limits.h"
#include "server/maps/map_store.h"
#include "server/open_calls.h"
#include "server/worker_pool.h"

namespace dcloc::server {

/// What calls that use the store share; outlives them.
struct StorageHost {
  MapStore& store;
  WorkerPool& pool;  ///< for all that may wait for a disk
  OpenCalls& open_calls;
  const AccessControl& access;
  const Limits& limits;
};

}  // namespace dcloc::server
