#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "core/map/radar_map.h"

namespace dcloc::server {

/// The storage of map files, each named by the SHA-256 of its bytes. Thread-safe; calls may block
/// on storage. Unavailable: the storage is away, and what is there is not known; whoever tries
/// again later may find it back.
class MapFiles {
 public:
  virtual ~MapFiles() = default;

  /// Moves the local file `path`, whose bytes have this hash, into the storage. Durable when it
  /// returns. An existing file of that hash is replaced.
  virtual absl::Status Keep(const std::filesystem::path& path, absl::string_view sha256) = 0;

  /// A file's bytes in this process's own memory, compared with their hash. Errors of
  /// `ReadMapFile`.
  virtual absl::StatusOr<std::vector<std::byte>> Read(absl::string_view sha256) = 0;

  /// The map of such bytes, verified: what becomes of the file later does not matter. Errors of
  /// `ReadMap`.
  virtual absl::StatusOr<std::shared_ptr<const RadarMap>> Open(absl::string_view sha256);

  /// Reads the whole file, a piece at a time. NotFound; DataLoss: its bytes have another hash.
  /// `pace` is called with the size of each piece; when it returns false, Cancelled.
  virtual absl::Status Check(absl::string_view sha256,
                             absl::FunctionRef<bool(std::size_t)> pace) = 0;

  /// Removes a file if it is there.
  virtual absl::Status Remove(absl::string_view sha256) = 0;

  /// Sets a file aside: it is in quarantine from now on, and no more among the others.
  virtual absl::Status Quarantine(absl::string_view sha256) = 0;

  /// Adds `served`, the time served since the call before, to the time in quarantine of what is set
  /// aside, and removes what has been there for `limit`; returns how many files.
  virtual absl::StatusOr<int> RemoveExpiredQuarantine(std::chrono::nanoseconds served,
                                                      std::chrono::nanoseconds limit) = 0;

  /// Files that are set aside.
  virtual absl::StatusOr<int> QuarantinedCount() = 0;

  /// A file's size in bytes; 0 when it is not there, DataLoss when something else is in its place.
  virtual absl::StatusOr<std::int64_t> SizeOf(absl::string_view sha256) = 0;

  /// The hashes of all files.
  virtual absl::StatusOr<std::vector<std::string>> List() = 0;
};

}  // namespace dcloc::server
