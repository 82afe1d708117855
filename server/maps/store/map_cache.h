#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace dcloc::server {

/// What a cache has done so far.
struct MapCacheCounts {
  std::atomic<std::int64_t> hits = 0;
  std::atomic<std::int64_t> misses = 0;
  std::atomic<std::int64_t> evictions = 0;
  std::atomic<std::int64_t> damaged = 0;     ///< copies that had other bytes, and were removed
  std::atomic<std::int64_t> not_stored = 0;  ///< files that found no room, or could not be written
  std::atomic<std::int64_t> size_bytes = 0;  ///< when it was looked at last
};

/// Copies of map files in a folder of this host, each named by the SHA-256 of its bytes, together
/// at most so many bytes. The least recently used ones go first, but none that someone reads.
///
/// Several processes may share the folder: files appear whole, by a rename, and each is compared
/// with its hash when it is read. So nothing depends on what a crash, a full disk or an operator
/// who empties the folder leaves behind. Thread-safe; calls wait for the disk alone.
class MapCache {
 public:
  /// Makes the folder if it is not there, readable by its owner alone, and removes what writers
  /// that died have left. `max_bytes` > 0.
  static absl::StatusOr<std::unique_ptr<MapCache>> Open(const std::filesystem::path& folder,
                                                        std::int64_t max_bytes);

  /// A file's bytes, which have this hash; it is now the one used last. NotFound: it is not here,
  /// or was damaged and is removed. ResourceExhausted: there is not enough memory.
  absl::StatusOr<std::vector<std::byte>> Read(absl::string_view sha256);

  /// Keeps a copy of a file, if there is room. That it cannot is logged and counted, and hurts
  /// nobody.
  void Write(absl::string_view sha256, std::span<const std::byte> bytes);

  /// Removes a copy if it is there.
  void Remove(absl::string_view sha256);

  const MapCacheCounts& counts() const { return counts_; }
  std::int64_t max_bytes() const { return max_bytes_; }

 private:
  MapCache(std::filesystem::path folder, std::int64_t max_bytes)
      : folder_(std::move(folder)), max_bytes_(max_bytes) {}

  absl::Status TryWrite(absl::string_view sha256, std::span<const std::byte> bytes);

  const std::filesystem::path folder_;
  const std::int64_t max_bytes_;
  std::atomic<std::int64_t> part_count_ = 0;  ///< names of what is not yet whole
  MapCacheCounts counts_;
};

}  // namespace dcloc::server
