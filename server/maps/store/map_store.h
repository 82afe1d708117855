#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "core/map/radar_map.h"
#include "server/base/clock.h"
#include "server/base/keyed_mutex.h"
#include "server/maps/catalogue/build_queue.h"
#include "server/maps/catalogue/catalogue.h"
#include "server/maps/store/incoming_files.h"
#include "server/maps/store/kept_files.h"
#include "server/maps/store/map_files.h"
#include "server/maps/store/store_check.h"
#include "server/maps/store/tenant_quota.h"
#include "server/maps/store/warm_maps.h"

namespace dcloc::server {

/// A version whose map is in memory.
struct LoadedMap {
  MapVersionRecord record;
  std::shared_ptr<const RadarMap> map;
  bool was_in_memory = false;  ///< a session used it already, or it was kept warm
};

/// What a store is made of. Which implementations these are is chosen in `app/storage.h`.
struct MapStoreParts {
  std::unique_ptr<Catalogue> catalogue;     ///< may be shared with other processes
  std::unique_ptr<MapFiles> files;          ///< as far as the catalogue is
  std::unique_ptr<IncomingFiles> incoming;  ///< this process's own
  std::unique_ptr<BuildQueue> builds;       ///< as far as the catalogue is shared
  std::unique_ptr<KeptFiles> build_inputs;  ///< likewise
  std::string holder;                       ///< names this process in the catalogue's holds
};

struct MapStoreOptions {
  /// Bound on the versions that stay in memory without a session.
  std::int64_t max_warm_bytes = std::int64_t{1} << 30;
  /// How long the bytes of an interrupted upload are kept, in time served.
  std::chrono::nanoseconds unfinished_upload_timeout = std::chrono::hours(24);
  /// How long files without a version are kept in quarantine, in time served; 0: for good.
  std::chrono::nanoseconds quarantine_time = std::chrono::days(30);
};

/// The server's maps: which exist (Catalogue), their files (MapFiles), uploads (IncomingFiles) and
/// which versions are in use. All users of a file share one copy in memory, and all users of a
/// version one hold in the catalogue. A version is in use as long as a `LoadedMap::map` of it
/// exists; that may outlive the store, and destroying it does not wait for storage. Active versions
/// and canaries stay in memory within bounds (WarmMaps). Thread-safe; calls may block on storage,
/// but `Acquire` of a version in memory never waits for a change that another call makes.
class MapStore {
 public:
  /// Checks the catalogue and the files, repairs what a crash left behind, and logs what it did.
  /// FailedPrecondition when there are files for which the catalogue cannot account (`CheckStore`).
  static absl::StatusOr<std::unique_ptr<MapStore>> Open(MapStoreParts parts,
                                                        const MapStoreOptions& options);

  /// For reading; changes go through the store.
  Catalogue& catalogue() { return *parts_.catalogue; }

  /// For reading, beside the store.
  MapFiles& files() { return *parts_.files; }

  IncomingFiles& incoming() { return *parts_.incoming; }
  TenantQuota& quota() { return quota_; }
  BuildQueue& builds() { return *parts_.builds; }
  KeptFiles& build_inputs() { return *parts_.build_inputs; }

  /// Names this process among those that share the store.
  const std::string& holder() const { return parts_.holder; }

  /// What `Open` found and did.
  const StoreReport& report() const { return report_; }

  /// A version, loaded and verified; `version` 0 is the active one. Errors of
  /// Catalogue::GetVersion, or DataLoss when the file is damaged.
  absl::StatusOr<LoadedMap> Acquire(absl::string_view map_name, std::int64_t version);

  /// The version for a vehicle that asks for the active one: the canary for its share of the
  /// vehicles. If the canary cannot be loaded, it is the active one, and the log says so.
  absl::StatusOr<LoadedMap> AcquireFor(absl::string_view map_name, absl::string_view vehicle_id);

  /// Adds a version from a local file that was verified as `map` and has this hash; moves the file
  /// into the store. While the result exists, callers that ask for the version get the same map,
  /// which is not verified again.
  absl::StatusOr<LoadedMap> Add(const std::filesystem::path& path, absl::string_view map_name,
                                absl::string_view sha256, std::shared_ptr<const RadarMap> map);

  /// Adds a version of a file that a version of maps with this prefix (Catalogue::ListMaps) has
  /// already. NotFound when there is none, or its file is not there or damaged.
  absl::StatusOr<MapVersionRecord> AddStored(absl::string_view prefix, absl::string_view map_name,
                                             absl::string_view sha256);

  /// Whether `AddStored` would find the file, whole. Reads all of it.
  absl::StatusOr<bool> HasStored(absl::string_view prefix, absl::string_view sha256);

  /// Loads and verifies a version, and only then makes it the active one. Errors of `Acquire`; then
  /// the old version stays active.
  absl::StatusOr<MapRecord> Activate(absl::string_view map_name, std::int64_t version);

  /// The same for the version that was active before. FailedPrecondition when there is none.
  absl::StatusOr<MapRecord> RollBack(absl::string_view map_name);

  /// The same for a share of the vehicles; version 0 and share 0 for none. FailedPrecondition: the
  /// version is active.
  absl::StatusOr<MapRecord> SetCanary(absl::string_view map_name, std::int64_t version,
                                      double share);

  /// Errors of the catalogue, such as FailedPrecondition while a version is in use. Their files go
  /// too, unless another version has them or another process is storing them (`RemoveOrphan`). A
  /// file that cannot be removed is set aside at the next start.
  absl::Status DeleteVersion(absl::string_view map_name, std::int64_t version);
  absl::Status DeleteMap(absl::string_view map_name);

  /// Removes unfinished uploads that are too old; returns how many. `served` is the time served
  /// since the call before, which alone makes them older: the host's clock may jump.
  absl::StatusOr<int> RemoveStaleUploads(std::chrono::nanoseconds served);

  /// The same for files that have been in quarantine for too long. Of the processes that share the
  /// files one does it; the others return 0. Not for several threads at once.
  absl::StatusOr<int> RemoveExpiredQuarantine(std::chrono::nanoseconds served);

  /// As `SetLooseFilesAside` of the store's check: what another process left that died.
  absl::StatusOr<int> SetLooseFilesAside();

  /// Files in memory.
  int loaded_map_count();

  /// Files in quarantine, as they were counted at the start and with each call of
  /// `RemoveExpiredQuarantine`; none when that failed. Never waits.
  std::optional<int> quarantined_count() const;

 private:
  struct Loaded;
  struct Use;
  using Key = WarmMaps::Key;

  MapStore(MapStoreParts parts, const MapStoreOptions& options);

  void CountQuarantine();

  /// Moves the file into the store and adds its version.
  absl::StatusOr<MapVersionRecord> Store(const std::filesystem::path& path,
                                         absl::string_view map_name, absl::string_view sha256,
                                         const RadarMap& map);
  /// A map whose labels have just changed; what has a label stays in memory.
  absl::StatusOr<MapRecord> Relabelled(absl::string_view map_name, const LoadedMap& loaded);

  // With the mutex held.
  absl::StatusOr<std::shared_ptr<Use>> UseVersion(const MapVersionRecord& record);
  void KeepWarm(const MapRecord& map, const LoadedMap& loaded);

  /// With the change mutex held.
  void RemoveFile(absl::string_view sha256);

  const MapStoreParts parts_;
  const MapStoreOptions options_;
  StoreReport report_;
  TenantQuota quota_;
  std::optional<Hold> sweeps_;               ///< this process counts the time in quarantine
  std::atomic<int> quarantined_count_ = -1;  ///< -1: not known
  KeyedMutex file_mutexes_;  ///< by hash, of files that are being stored; taken before the others

  /// Keeps labels, versions and what is in memory consistent. Held while a row is written and while
  /// a file is removed, but not while one is stored, which may take minutes. Taken before `mutex_`.
  std::mutex change_mutex_;
  /// Keeps the maps in memory consistent. Held while a row is read, which waits for no change.
  std::mutex mutex_;
  std::map<std::string, std::weak_ptr<Loaded>> loaded_;  ///< by hash; in memory, used or warm
  std::map<Key, std::weak_ptr<Use>> uses_;               ///< those in use
  WarmMaps warm_;
};

}  // namespace dcloc::server
