#pragma once

#include <prometheus/collectable.h>

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "server/base/peer_wait.h"
#include "server/base/worker_pool.h"
#include "server/config/limits.h"
#include "server/config/served_certificates.h"
#include "server/maps/store/map_cache.h"
#include "server/maps/store/map_scrub.h"
#include "server/maps/store/map_store.h"
#include "server/net/call_gate.h"
#include "server/objects/object_store.h"
#include "server/passes/pass_counts.h"
#include "server/sessions/session_registry.h"

namespace dcloc::server {

/// Gauges of the server's current state, computed when Prometheus asks. Thread-safe.
class StateMetrics final : public prometheus::Collectable {
 public:
  /// The sources of the gauges; they outlive this object.
  struct Sources {
    const SessionRegistry& registry;
    MapStore& store;
    const MapScrub& scrub;
    const WorkerPool& localization_pool;
    const WorkerPool& storage_pool;
    std::function<bool()> draining;
    std::function<int()> unopened_stream_count;
    std::function<int()> awaited_request_count;
    std::function<int()> health_watcher_count;
    std::function<int()> download_count;
    std::function<int()> replica_count;  ///< servers that it knows, itself among them
    const Limits& limits;
    const PeerFaultCounts& peer_faults;
    const CallGate::RefusedCounts& refused_calls;
    const ServedCertificates* certificates;  ///< null without TLS
    std::function<bool()> answering;         ///< whether the server answers its own connections
    std::function<std::int64_t()> refused_connection_count;
    const ObjectStore* objects;  ///< null: map files are in a folder
    const MapCache* cache;       ///< null: there is none
    const PassCounts& passes;
    std::function<std::int64_t()> withdrawn_canary_count;
    std::string version;
  };

  explicit StateMetrics(Sources sources) : sources_(std::move(sources)) {}

  std::vector<prometheus::MetricFamily> Collect() const override;

 private:
  void AddWork(std::vector<prometheus::MetricFamily>& families) const;
  void AddPeers(std::vector<prometheus::MetricFamily>& families) const;
  void AddMapFiles(std::vector<prometheus::MetricFamily>& families) const;

  const Sources sources_;
};

}  // namespace dcloc::server
