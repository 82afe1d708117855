#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/base/files.h"

namespace dcloc::server {

/// What making room in a cache came to.
struct CacheRoom {
  std::int64_t used_bytes = 0;  ///< of what is there
  int evicted_count = 0;
};

/// The folder of a cache that processes share, locked by one of them:
///
///     SHA256.dcmap        a file; its time of modification says when it was used last
///     SHA256.PID-N.part   not yet whole; locked by its writer while that lives
///     lock                held while room is made
class CacheFolder {
 public:
  /// Locks the folder; waits for another process that makes room, which is quick. Makes it if it is
  /// not there, its owner's alone. FailedPrecondition: it is another user's. Unavailable: another
  /// one has had it for a second.
  static absl::StatusOr<CacheFolder> Lock(const std::filesystem::path& folder);

  /// Removes parts whose writers are gone, and the files that were used least recently, but none
  /// that is being read, until `size_bytes` more make at most `max_bytes`. ResourceExhausted: they
  /// do not.
  absl::StatusOr<CacheRoom> MakeRoom(std::int64_t size_bytes, std::int64_t max_bytes);

  /// Where a file is in such a folder.
  static std::filesystem::path PathIn(const std::filesystem::path& folder,
                                      absl::string_view sha256);

 private:
  CacheFolder(std::filesystem::path folder, FileDescriptor lock)
      : folder_(std::move(folder)), lock_(std::move(lock)) {}

  std::filesystem::path folder_;
  FileDescriptor lock_;
};

/// A file of a cache that is being written; removed unless it is moved to its place.
class CachePart {
 public:
  /// Begins one that will have `size_bytes`, with room for all of them. ResourceExhausted: the disk
  /// is full.
  static absl::StatusOr<CachePart> Begin(const std::filesystem::path& folder,
                                         const std::string& name, std::int64_t size_bytes);

  CachePart(CachePart&& other) noexcept
      : path_(std::exchange(other.path_, {})), file_(std::move(other.file_)) {}
  CachePart& operator=(CachePart&& other) noexcept;
  ~CachePart();

  const FileDescriptor& file() const { return file_; }

  absl::Status MoveTo(const std::filesystem::path& path);

 private:
  CachePart(std::filesystem::path path, FileDescriptor file)
      : path_(std::move(path)), file_(std::move(file)) {}

  std::filesystem::path path_;  ///< empty once it has moved
  FileDescriptor file_;
};

/// Says that a file of a cache is being read, until the descriptor closes, and is used now.
void MarkUsed(const FileDescriptor& file);

}  // namespace dcloc::server
