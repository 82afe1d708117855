#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <system_error>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

/// The few calls to the operating system that need more than std::filesystem.
namespace dcloc::server {

/// The system's error about a file: ResourceExhausted when the disk or a limit is full, NotFound
/// when there is no such file, else Internal. The message may go to a client, so the path is not in
/// it but beside it (`WithPath`). This holds for all errors of this file's functions.
absl::Status FileError(const std::error_code& error, const std::filesystem::path& path);

/// The same error with the path in front of its message, if it has one: for logs and operators.
absl::Status WithPath(const absl::Status& status);

/// An error that is about the file at `path`, which `WithPath` then names.
absl::Status AboutFile(absl::Status status, const std::filesystem::path& path);

/// A file descriptor that closes itself.
class FileDescriptor {
 public:
  explicit FileDescriptor(int descriptor = -1) : descriptor_(descriptor) {}
  FileDescriptor(FileDescriptor&& other) noexcept;
  FileDescriptor& operator=(FileDescriptor&& other) noexcept;
  ~FileDescriptor();

  int get() const { return descriptor_; }

  /// Gives it away: whoever takes it closes it.
  int Release() { return std::exchange(descriptor_, -1); }

 private:
  int descriptor_;
};

/// Opens a file for reading and writing, and makes it if it is not there.
absl::StatusOr<FileDescriptor> OpenOrCreate(const std::filesystem::path& path);

/// Opens a regular file for reading. DataLoss when it is something else.
absl::StatusOr<FileDescriptor> OpenToRead(const std::filesystem::path& path);

/// Writes all of `bytes` at the file's current position. ResourceExhausted when the disk is full.
absl::Status WriteAll(const FileDescriptor& file, std::span<const std::byte> bytes);

/// Fills `buffer` from the file's current position; returns the number of bytes read.
absl::StatusOr<std::size_t> ReadUpTo(const FileDescriptor& file, std::span<std::byte> buffer);

/// The size of an open file.
absl::StatusOr<std::int64_t> FileSize(const FileDescriptor& file);

/// Cuts the file off at `size_bytes` and goes to its beginning.
absl::Status Truncate(const FileDescriptor& file, std::int64_t size_bytes);

/// A regular file's size; 0 when there is none, DataLoss when it is something else.
absl::StatusOr<std::int64_t> FileSize(const std::filesystem::path& path);

/// Whether there is anything at `path`, if only a link to nothing. True where nobody can tell.
bool IsThere(const std::filesystem::path& path);

/// Removes a file if it is there.
absl::Status RemoveFile(const std::filesystem::path& path);

/// Moves a file within a file system, in place of one that is there.
absl::Status MoveFile(const std::filesystem::path& from, const std::filesystem::path& to);

/// Makes a file's bytes, or a folder's entries, durable.
absl::Status Sync(const FileDescriptor& file);
absl::Status SyncFile(const std::filesystem::path& path);
absl::Status SyncFolder(const std::filesystem::path& folder);

/// Creates `folder` and its parents.
absl::Status CreateFolders(const std::filesystem::path& folder);

/// Holds `path` until the descriptor closes. FailedPrecondition when another process holds it.
absl::StatusOr<FileDescriptor> LockFile(const std::filesystem::path& path);

}  // namespace dcloc::server
