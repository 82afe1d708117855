#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "core/map/radar_map.h"

namespace dcloc::server {

/// The storage of map files, each named by the SHA-256 of its bytes. Thread-safe; calls may block
/// on storage.
class MapFiles {
 public:
  virtual ~MapFiles() = default;

  /// Moves the local file `path`, whose bytes have this hash, into the storage. Durable when it
  /// returns. An existing file of that hash is replaced.
  virtual absl::Status Keep(const std::filesystem::path& path, absl::string_view sha256) = 0;

  /// Errors of RadarMap::Open.
  virtual absl::StatusOr<std::shared_ptr<const RadarMap>> Open(absl::string_view sha256) = 0;

  /// Removes a file if it is there; maps that were opened from it stay whole.
  virtual absl::Status Remove(absl::string_view sha256) = 0;

  /// A file's size in bytes; 0 when it is not there.
  virtual absl::StatusOr<std::int64_t> SizeOf(absl::string_view sha256) = 0;

  /// The hashes of all files.
  virtual absl::StatusOr<std::vector<std::string>> List() = 0;
};

}  // namespace dcloc::server
