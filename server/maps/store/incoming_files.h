#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/base/files.h"
#include "server/base/sha256.h"
#include "server/maps/store/served_ages.h"

namespace dcloc::server {

/// A file that is being uploaded, and its writer. There is one writer at a time: who takes the same
/// file later replaces the earlier writer. Not thread-safe, except for taking the file.
class IncomingFile {
 public:
  /// Excludes all other writers as long as it lives.
  using Hold = std::unique_lock<std::mutex>;

  /// Waits until no other writer works on the file. Aborted if another one has taken it meanwhile.
  absl::StatusOr<Hold> Lock() const;

  // With the hold:

  /// Truncates the file to `offset_bytes`, or creates it, and hashes the rest. Bytes written later
  /// are appended.
  absl::Status BeginAt(std::int64_t offset_bytes);
  absl::Status Write(absl::string_view bytes);
  bool begun() const { return descriptor_.has_value(); }

  /// Bytes in the file.
  absl::StatusOr<std::int64_t> Size() const { return FileSize(path_); }
  std::int64_t hashed_bytes() const { return hashed_bytes_; }

  /// The hash of the whole file, which is then durable. Nothing may be written after this call.
  absl::StatusOr<std::string> Finish();

  absl::Status Remove() { return RemoveFile(path_); }
  const std::filesystem::path& path() const { return path_; }

 private:
  friend class IncomingFiles;
  struct Owner {
    std::mutex mutex;
    std::int64_t number = 0;  ///< of the present writer
  };

  IncomingFile(std::filesystem::path path, std::shared_ptr<Owner> owner, std::int64_t number)
      : path_(std::move(path)), owner_(std::move(owner)), number_(number) {}

  std::filesystem::path path_;
  std::shared_ptr<Owner> owner_;
  std::int64_t number_;
  std::optional<FileDescriptor> descriptor_;
  std::int64_t hashed_bytes_ = 0;
  Sha256 hash_;
};

/// Files that are being uploaded, each named by its tenant and by the SHA-256 that the whole file
/// will have. The bytes of an interrupted upload stay, so that another call can continue it.
/// Thread-safe; calls may block on storage.
class IncomingFiles {
 public:
  /// Creates the folder if needed, and removes files that are no uploads; returns how many.
  static absl::StatusOr<std::unique_ptr<IncomingFiles>> Open(const std::filesystem::path& folder);

  /// Takes a file for writing. Waits for its present writer's current operation, and replaces that
  /// writer.
  IncomingFile Take(absl::string_view tenant, absl::string_view sha256);

  /// Makes the received bytes of a file durable; returns how many there are.
  absl::StatusOr<std::int64_t> DurableSize(absl::string_view tenant,
                                           absl::string_view sha256) const;

  /// The hashes that the tenant's files will have, each with the bytes that are there.
  absl::StatusOr<std::map<std::string, std::int64_t>> SizesOf(absl::string_view tenant) const;

  /// Adds `served`, the time served since the call before, to the ages of files that have no writer
  /// and have not grown, and removes those of age `limit`; returns how many.
  absl::StatusOr<int> RemoveStale(std::chrono::nanoseconds served, std::chrono::nanoseconds limit);

  /// Files that there are.
  absl::StatusOr<int> Count() const;

  /// Other files in it are removed by the next `Open`.
  const std::filesystem::path& folder() const { return folder_; }

  /// Files of other names that `Open` has removed.
  int removed_count() const { return removed_count_; }

 private:
  explicit IncomingFiles(std::filesystem::path folder)
      : folder_(std::move(folder)), ages_(folder_.string() + ".ages") {}
  std::filesystem::path PathOf(absl::string_view tenant, absl::string_view sha256) const;

  std::filesystem::path folder_;
  ServedAges ages_;
  int removed_count_ = 0;
  std::mutex mutex_;
  std::map<std::filesystem::path, std::weak_ptr<IncomingFile::Owner>> owners_;
};

}  // namespace dcloc::server
