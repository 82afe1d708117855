#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/map/map_builder.h"
#include "core/odometry/learned_stamps.h"
#include "server/base/worker_pool.h"
#include "server/maps/jobs/scan_spool.h"
#include "server/maps/jobs/upload.h"
#include "server/maps/store/map_store.h"

namespace dcloc::server {

/// The map to be built.
struct BuildRequest {
  std::string tenant;
  std::string map_name;
  Rig rig;
  MapBuilderOptions options;
  bool activate = false;
  UploadLimits limits;  ///< of what comes out
};

enum class BuildState { kRunning, kDone, kFailed, kCancelled };

/// A build as others see it.
struct BuildRecord {
  std::string build_id;
  std::string map_name;  ///< without the tenant
  BuildState state = BuildState::kRunning;
  std::int64_t scan_count = 0;
  std::int64_t done_scan_count = 0;
  SystemTime create_time;
  absl::Status error;                       ///< of a failed one
  std::optional<MapVersionRecord> version;  ///< of one that is done
};

/// Builds of maps from scans: one at a time, in the order in which they were started, on a thread
/// of their own. They are kept in memory. The end of the process ends them, and the next process
/// reports them as failed. Thread-safe.
class MapBuilds {
 public:
  /// `store` outlives it.
  explicit MapBuilds(MapStore& store);
  /// Interrupts running builds.
  ~MapBuilds();
  MapBuilds(const MapBuilds&) = delete;
  MapBuilds& operator=(const MapBuilds&) = delete;

  /// ResourceExhausted when the tenant has too many under way, or the disk is full.
  absl::StatusOr<BuildRecord> Start(BuildRequest request, std::unique_ptr<ScanSpool> scans);

  /// NotFound: the tenant has no such build, or it ended too long ago.
  absl::StatusOr<BuildRecord> Get(absl::string_view tenant, absl::string_view build_id) const;

  /// The tenant's, newest first.
  std::vector<BuildRecord> List(absl::string_view tenant) const;

  /// Cancels a build, unless it has ended; returns before it ends. NotFound as above.
  absl::StatusOr<BuildRecord> Cancel(absl::string_view tenant, absl::string_view build_id);

 private:
  struct Build {
    BuildRequest request;
    std::unique_ptr<ScanSpool> scans;
    std::atomic<bool> cancelled = false;
    std::atomic<std::int64_t> done_scan_count = 0;
    BuildRecord record;  ///< but for the count that is done; with the mutex held
  };

  void Run(Build& build);
  absl::StatusOr<MapVersionRecord> Make(Build& build) const;
  absl::StatusOr<MeasuredStamps> StampsOf(Build& build) const;
  absl::StatusOr<std::vector<std::byte>> AddScans(Build& build) const;
  absl::StatusOr<MapVersionRecord> Keep(const BuildRequest& request,
                                        const std::vector<std::byte>& bytes) const;
  // With the mutex held.
  std::shared_ptr<Build> Find(absl::string_view tenant, absl::string_view build_id) const;
  static BuildRecord RecordOf(const Build& build);
  void ForgetOldest();

  MapStore& store_;
  std::atomic<bool> stopping_ = false;
  mutable std::mutex mutex_;
  std::deque<std::shared_ptr<Build>> builds_;  ///< oldest first
  WorkerPool pool_{1, 1};                      ///< last: its tasks use the others
};

}  // namespace dcloc::server
