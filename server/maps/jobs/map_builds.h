#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "dcloc/v1/map_service.pb.h"
#include "server/base/framed_file.h"
#include "server/base/ticker.h"
#include "server/base/worker_pool.h"
#include "server/config/limits.h"
#include "server/maps/catalogue/build_queue.h"
#include "server/maps/jobs/build_intake.h"
#include "server/maps/jobs/build_progress.h"
#include "server/maps/jobs/map_build.h"
#include "server/maps/jobs/upload.h"
#include "server/maps/store/map_store.h"
#include "server/passes/pass_store.h"

namespace dcloc::server {

/// Builds of map versions, from scans that clients send or passes that the server keeps. They wait
/// in the store's queue, which servers may share. This server builds one at a time, on a thread of
/// its own, under a lease. The end of the process gives back what it builds; if it dies, the lease
/// ends. Then another server, or this one when it starts again, builds it anew from the scans,
/// which lie beside the maps until the build has ended. The same scans give the same file, so two
/// that build at once add one version. Thread-safe.
class MapBuilds {
 public:
  /// `store`, `passes` and `limits` outlive it.
  MapBuilds(MapStore& store, PassStore& passes, const Limits& limits);
  /// Interrupts what is built here.
  ~MapBuilds();
  MapBuilds(const MapBuilds&) = delete;
  MapBuilds& operator=(const MapBuilds&) = delete;

  /// ResourceExhausted when the tenant has too many under way, or the disk is full.
  absl::StatusOr<v1::MapBuild> Start(const std::string& tenant, BuildInput input);

  /// NotFound: the tenant has no such build, or it ended too long ago.
  absl::StatusOr<v1::MapBuild> Get(absl::string_view tenant, absl::string_view build_id) const;

  /// The tenant's, newest first.
  absl::StatusOr<std::vector<v1::MapBuild>> List(absl::string_view tenant) const;

  /// Cancels a build, unless it has ended; returns before it ends. NotFound as above.
  absl::StatusOr<v1::MapBuild> Cancel(absl::string_view tenant, absl::string_view build_id);

 private:
  /// A build that this server has taken.
  struct Running {
    Running(const BuildRow& taken, const std::string& holder);
    const BuildRow row;
    const BuildLease lease;
    BuildProgress progress;
    std::atomic<bool> lost = false;  ///< another one may build it now
  };

  BuildQueue& queue() const { return store_.builds(); }
  void Wake();
  void BuildAll();
  /// False when nothing is to be built now.
  bool BuildNext();
  /// False without memory to say how it ended: then the queue gives it again.
  bool Build(const BuildRow& row);
  void Renew(Running& running) const;
  absl::StatusOr<MapVersionRecord> Make(Running& running) const;
  absl::StatusOr<std::vector<std::byte>> MakeBytes(Running& running, const BuildRequest& request,
                                                   v1::MapBuildMethod method,
                                                   FramedReader& spool) const;
  absl::StatusOr<MapVersionRecord> Keep(const Running& running, bool activate,
                                        const std::vector<std::byte>& bytes) const;
  /// OK while it is still to be built here.
  absl::Status Confirm(Running& running) const;
  void End(Running& running, const absl::StatusOr<MapVersionRecord>& version) const;
  v1::MapBuild MessageOf(const BuildRow& row) const;
  void Tick();
  void RemoveOrphans();

  MapStore& store_;
  PassStore& passes_;
  const Limits& limits_;
  std::atomic<bool> stopping_ = false;
  std::atomic<bool> busy_ = false;
  mutable std::mutex mutex_;
  std::shared_ptr<Running> running_;  ///< null while nothing is built here
  std::set<std::string> orphans_;     ///< inputs that no build wanted last time; the ticker's
  std::chrono::steady_clock::time_point next_look_for_orphans_{};  ///< the ticker's
  WorkerPool pool_{1, 1};                                          ///< its tasks use the others
  Ticker ticker_;                                                  ///< last: it posts to the pool
};

}  // namespace dcloc::server
