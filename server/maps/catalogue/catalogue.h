#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "core/map/radar_map.h"
#include "server/base/clock.h"
#include "server/maps/catalogue/coverage.h"
#include "server/maps/catalogue/hold.h"

namespace dcloc::server {

/// A map: a name, which holds its tenant (`ScopedMapName`), and its versions.
struct MapRecord {
  std::string name;
  std::int64_t active_version = 0;  ///< 0: none
  int version_count = 0;
  SystemTime create_time;
  std::int64_t previous_version = 0;  ///< active before; 0: none
  std::int64_t canary_version = 0;    ///< 0: none
  double canary_share = 0.0;          ///< of the vehicles, [0, 1]
};

/// A version: a file that never changes.
struct MapVersionRecord {
  std::string map_name;
  std::int64_t version = 0;  ///< from 1; never used again
  bool active = false;
  std::string sha256;  ///< names the file
  SystemTime create_time;
  MapInfo info;
};

/// An active version that covers a place.
struct CoverageRecord {
  std::string map_name;
  std::int64_t version = 0;
  double distance_m = 0.0;  ///< to the nearest box
};

/// Which maps and versions exist, and which versions are in use. Thread-safe; calls may block on
/// storage, but those that only read, and HoldVersion, never wait for a change that another thread
/// or process is making. Each change is atomic, and durable when the call returns. Errors beyond
/// those named are the storage's own: Internal, ResourceExhausted, DataLoss, and Unavailable when
/// another process keeps it locked. After Internal a change may have been made or not.
///
/// Several processes may share one catalogue if its implementation says so. So a process that uses
/// a version or stores a file takes a hold of it here, not only in its own memory. `holder` names
/// the process: the same name for all of its holds, and one that no earlier process had. A hold
/// lasts until it is given back or its holder has died. How the implementation notices that (a
/// lease, a broken connection) is its own choice. Localizing a scan neither takes nor gives back a
/// hold.
class Catalogue {
 public:
  virtual ~Catalogue() = default;

  /// At most `limit` maps of one tenant with a name above `after_name`, by ascending name. `prefix`
  /// is the tenant's: the names begin with it and have no slash after it.
  virtual absl::StatusOr<std::vector<MapRecord>> ListMaps(absl::string_view prefix,
                                                          absl::string_view after_name,
                                                          int limit) = 0;

  /// Bytes of all files of such maps together, each counted once however many versions have it.
  virtual absl::StatusOr<std::int64_t> SizeOfMaps(absl::string_view prefix) = 0;

  /// NotFound when there is no such map.
  virtual absl::StatusOr<MapRecord> GetMap(absl::string_view map_name) = 0;

  /// At most `limit` versions below `below_version`, newest first. NotFound: no such map.
  virtual absl::StatusOr<std::vector<MapVersionRecord>> ListVersions(absl::string_view map_name,
                                                                     std::int64_t below_version,
                                                                     int limit) = 0;

  /// `version` 0 is the active one. NotFound: no such map or version; FailedPrecondition: the map
  /// has no active version.
  virtual absl::StatusOr<MapVersionRecord> GetVersion(absl::string_view map_name,
                                                      std::int64_t version) = 0;

  /// Adds a version, and the map if it is new. If a version of the map has this file already,
  /// returns that version.
  virtual absl::StatusOr<MapVersionRecord> AddVersion(absl::string_view map_name,
                                                      absl::string_view sha256, const MapInfo& info,
                                                      const std::vector<CoverageBox>& coverage) = 0;

  /// The version that was active becomes the previous one. A canary that becomes active is no
  /// longer the canary. NotFound: no such map or version.
  virtual absl::Status Activate(absl::string_view map_name, std::int64_t version) = 0;

  /// Version 0 and share 0: none. NotFound: no such map or version; FailedPrecondition: the version
  /// is active.
  virtual absl::Status SetCanary(absl::string_view map_name, std::int64_t version,
                                 double share) = 0;

  /// Keeps a version from being deleted. A version may be held several times. NotFound: no such map
  /// or version; Unavailable: it is being deleted at this moment.
  virtual absl::StatusOr<Hold> HoldVersion(absl::string_view map_name, std::int64_t version,
                                           absl::string_view holder) = 0;

  /// Locks a file's hash: taken by a process that stores the file and then adds its version, or
  /// that finds no version of it and removes it. One holder at a time, whether the file exists or
  /// not. Unavailable while it is held, also by the same holder.
  virtual absl::StatusOr<Hold> HoldFile(absl::string_view sha256, absl::string_view holder) = 0;

  /// NotFound: no such map or version; FailedPrecondition: it is held, active or the canary.
  virtual absl::Status DeleteVersion(absl::string_view map_name, std::int64_t version) = 0;

  /// With all of its versions. NotFound: no such map; FailedPrecondition: one of them is held.
  virtual absl::Status DeleteMap(absl::string_view map_name) = 0;

  /// Notes that a file may be there without a version: durable before the file is stored. Adding a
  /// version with the file ends that. Deleting the last version that has it begins it, in the same
  /// change.
  virtual absl::Status AddLooseFile(absl::string_view sha256) = 0;

  /// The file is gone, or was never there.
  virtual absl::Status RemoveLooseFile(absl::string_view sha256) = 0;

  virtual absl::StatusOr<std::vector<std::string>> ListLooseFiles() = 0;

  /// Whether any version has this file.
  virtual absl::StatusOr<bool> HasFile(absl::string_view sha256) = 0;

  /// The file's size in bytes if a version of the maps with this prefix (as in `ListMaps`) has it;
  /// else 0.
  virtual absl::StatusOr<std::int64_t> SizeOfFile(absl::string_view prefix,
                                                  absl::string_view sha256) = 0;

  /// The files of all versions, each once, with their sizes.
  virtual absl::StatusOr<std::vector<std::pair<std::string, std::int64_t>>> ListFiles() = 0;

  /// Versions without coverage, from a catalogue of an earlier program.
  virtual absl::StatusOr<std::vector<MapVersionRecord>> ListUncovered() = 0;

  /// Adds the coverage of a version that `ListUncovered` returned.
  virtual absl::Status AddCoverage(absl::string_view map_name, std::int64_t version,
                                   const std::vector<CoverageBox>& coverage) = 0;

  /// The active version of one map, if a box of it lies within `radius_m` of a place in its frame.
  /// NotFound: no such map.
  virtual absl::StatusOr<std::vector<CoverageRecord>> FindCoverage(absl::string_view map_name,
                                                                   const Eigen::Vector2d& p_map,
                                                                   double radius_m) = 0;

  /// The active versions that cover a place on the Earth, of such maps as with `ListMaps` that have
  /// an anchor; the nearest first, at most `limit`.
  virtual absl::StatusOr<std::vector<CoverageRecord>> FindCoverage(absl::string_view prefix,
                                                                   const GeodeticPosition& position,
                                                                   double radius_m, int limit) = 0;
};

}  // namespace dcloc::server
