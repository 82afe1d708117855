#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include "absl/strings/string_view.h"

#include "absl/status/status.h"
#include "absl/status/statusor.h"

/// The few calls to the operating system that need more than std::filesystem.
namespace dcloc::server {

/// A file descriptor that closes itself.
class FileDescriptor {
 public:
  explicit FileDescriptor(int descriptor = -1) : descriptor_(descriptor) {}
  FileDescriptor(FileDescriptor&& other) noexcept;
  FileDescriptor& operator=(FileDescriptor&& other) noexcept;
  ~FileDescriptor();

  int get() const { return descriptor_; }

 private:
  int descriptor_;
};

/// Creates a file of a new name that begins with `prefix` in `folder`, and opens it for writing.
struct TemporaryFile {
  FileDescriptor descriptor;
  std::filesystem::path path;
};
absl::StatusOr<TemporaryFile> CreateTemporaryFile(const std::filesystem::path& folder,
                                                  absl::string_view prefix);

/// Writes all of `bytes`. ResourceExhausted when the disk is full.
absl::Status WriteAll(const FileDescriptor& file, std::span<const std::byte> bytes);

/// Makes a file's bytes, or a folder's entries, durable.
absl::Status Sync(const FileDescriptor& file);
absl::Status SyncFolder(const std::filesystem::path& folder);

/// Makes `folder` and what lies above it.
absl::Status CreateFolders(const std::filesystem::path& folder);

/// Holds `path` until the descriptor closes. FailedPrecondition when another process holds it.
absl::StatusOr<FileDescriptor> LockFile(const std::filesystem::path& path);

}  // namespace dcloc::server
