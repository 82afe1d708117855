#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "absl/status/statusor.h"

namespace dcloc {

/// A file's bytes, mapped read-only. Who truncates the file meanwhile makes reading it fault
/// (SIGBUS): map only files that nobody changes.
class MappedFile {
 public:
  /// NotFound, or what the system says, with the path; DataLoss for what is no regular file.
  static absl::StatusOr<MappedFile> Open(const std::filesystem::path& path);

  MappedFile(MappedFile&& other) noexcept;
  MappedFile& operator=(MappedFile&& other) noexcept;
  ~MappedFile();

  std::span<const std::byte> bytes() const { return bytes_; }

  /// Says that from `offset_bytes` on reads jump about, so that reading ahead is waste.
  void ExpectRandomReadsFrom(std::size_t offset_bytes) const;

 private:
  explicit MappedFile(std::span<const std::byte> bytes) : bytes_(bytes) {}

  std::span<const std::byte> bytes_;
};

}  // namespace dcloc
