#pragma once

#include <prometheus/collectable.h>

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "server/base/worker_pool.h"
#include "server/maps/store/map_store.h"
#include "server/sessions/session_registry.h"

namespace dcloc::server {

/// What the server is at the moment: looked up when Prometheus asks. Thread-safe.
class StateMetrics final : public prometheus::Collectable {
 public:
  /// Where to look; outlives it.
  struct Sources {
    const SessionRegistry& registry;
    MapStore& store;
    const WorkerPool& localization_pool;
    const WorkerPool& storage_pool;
    std::function<bool()> draining;
    std::function<bool()> answering;  ///< own connections are
    std::function<std::int64_t()> refused_connection_count;
    std::string version;
  };

  explicit StateMetrics(Sources sources) : sources_(std::move(sources)) {}

  std::vector<prometheus::MetricFamily> Collect() const override;

 private:
  const Sources sources_;
};

}  // namespace dcloc::server
