#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "absl/status/statusor.h"

namespace dcloc {

/// A file's bytes, mapped read-only. If the file is truncated meanwhile, reading it faults
/// (SIGBUS): map only files that do not change.
class MappedFile {
 public:
  /// Errors name the path: NotFound or another error of the system, DataLoss for what is not a
  /// regular file.
  static absl::StatusOr<MappedFile> Open(const std::filesystem::path& path);

  MappedFile(MappedFile&& other) noexcept;
  MappedFile& operator=(MappedFile&& other) noexcept;
  ~MappedFile();

  std::span<const std::byte> bytes() const { return bytes_; }

  /// Advises the system that reads from `offset_bytes` on are random, so that it does not read
  /// ahead.
  void ExpectRandomReadsFrom(std::size_t offset_bytes) const;

 private:
  explicit MappedFile(std::span<const std::byte> bytes) : bytes_(bytes) {}

  std::span<const std::byte> bytes_;
};

}  // namespace dcloc
