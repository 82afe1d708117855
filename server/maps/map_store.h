#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include "absl/strings/string_view.h"

#include "absl/status/statusor.h"
#include "core/map/radar_map.h"
#include "server/maps/catalogue.h"
#include "server/maps/files.h"
#include "server/maps/map_files.h"

namespace dcloc::server {

/// A version with its map in memory.
struct LoadedMap {
  MapVersionRecord record;
  std::shared_ptr<const RadarMap> map;
};

/// The server's maps: which there are (Catalogue), their files (MapFiles), and which are in use.
/// All who use a version share one copy in memory; it is in use as long as anyone holds
/// `LoadedMap::map`. Thread-safe; calls may block on storage.
class MapStore {
 public:
  /// Opens or creates the embedded store in `folder`, and removes what a crash left over.
  /// FailedPrecondition when another process has it open.
  static absl::StatusOr<std::unique_ptr<MapStore>> Open(const std::filesystem::path& folder);

  /// For reading and activating; adding and deleting go through the store.
  Catalogue& catalogue() { return *catalogue_; }

  /// A version, loaded and verified; `version` 0 is the active one. Errors of
  /// Catalogue::GetVersion, or DataLoss when the file is damaged.
  absl::StatusOr<LoadedMap> Acquire(absl::string_view map_name, std::int64_t version);

  /// Adds a version from a local file that was verified and has this hash; takes the file over.
  absl::StatusOr<MapVersionRecord> Add(const std::filesystem::path& path,
                                       absl::string_view map_name, absl::string_view sha256,
                                       const MapInfo& info, bool activate);

  /// Errors of the catalogue's, and FailedPrecondition while a version is in use.
  absl::Status DeleteVersion(absl::string_view map_name, std::int64_t version);
  absl::Status DeleteMap(absl::string_view map_name);

  /// Versions in memory.
  int loaded_map_count();

  /// Where uploads may put files that `Add` is to take over.
  const std::filesystem::path& incoming_folder() const { return incoming_folder_; }

 private:
  struct Loaded;
  using Key = std::pair<std::string, std::int64_t>;

  MapStore(FileDescriptor lock, std::filesystem::path incoming_folder,
           std::unique_ptr<Catalogue> catalogue, std::unique_ptr<MapFiles> files);

  absl::Status RemoveLeftovers();
  // With the mutex held.
  bool InUse(const Key& key) const;
  absl::Status RemoveFileUnlessNeeded(absl::string_view sha256);

  FileDescriptor lock_;
  std::filesystem::path incoming_folder_;
  std::unique_ptr<Catalogue> catalogue_;
  std::unique_ptr<MapFiles> files_;

  /// Ties what the catalogue says to which files and loaded maps there are. Held while a catalogue
  /// row is read or written and while a file is renamed, not while a map is read.
  std::mutex mutex_;
  std::map<Key, std::weak_ptr<Loaded>> loaded_;
};

}  // namespace dcloc::server
