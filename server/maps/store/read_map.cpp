#include "server/maps/store/read_map.h"

#include <fcntl.h>

#include <algorithm>
#include <cstddef>
#include <exception>
#include <span>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"

namespace dcloc::server {
namespace {

/// Small enough to be in the cache still when it is hashed.
constexpr std::size_t kPiece_bytes = std::size_t{256} << 10;

/// Fills `bytes` from a file that has as many.
absl::Status ReadAndHash(const FileDescriptor& file, std::span<std::byte> bytes, Sha256* hash) {
  while (!bytes.empty()) {
    const auto piece = bytes.first(std::min(kPiece_bytes, bytes.size()));
    const absl::StatusOr<std::size_t> size = ReadUpTo(file, piece);
    if (!size.ok()) return size.status();
    if (*size < piece.size()) return absl::DataLossError("the file became shorter meanwhile");
    hash->Update(piece);
    bytes = bytes.subspan(piece.size());
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::vector<std::byte>> MemoryForMap(std::int64_t size_bytes) {
  try {
    return std::vector<std::byte>(static_cast<std::size_t>(size_bytes));
  } catch (const std::exception&) {
    return absl::ResourceExhaustedError(
        absl::StrFormat("no memory is left for a map of %d bytes", size_bytes));
  }
}

absl::Status CheckMapHash(Sha256& hash, absl::string_view sha256) {
  const std::string found = hash.Finish();
  if (found == sha256) return absl::OkStatus();
  return absl::DataLossError(
      absl::StrFormat("the file's bytes have the hash %s; it must be %s", found, sha256));
}

absl::StatusOr<std::vector<std::byte>> ReadMapFile(const std::filesystem::path& path,
                                                   absl::string_view sha256) {
  const absl::StatusOr<FileDescriptor> file = OpenToRead(path);
  if (!file.ok()) return file.status();
  return ReadMapFile(*file, sha256);
}

absl::StatusOr<std::vector<std::byte>> ReadMapFile(const FileDescriptor& file,
                                                   absl::string_view sha256) {
  const absl::StatusOr<std::int64_t> size_bytes = FileSize(file);
  if (!size_bytes.ok()) return size_bytes.status();
  absl::StatusOr<std::vector<std::byte>> bytes = MemoryForMap(*size_bytes);
  if (!bytes.ok()) return bytes.status();
  Sha256 hash;
  absl::Status status = ReadAndHash(file, *bytes, &hash);
  if (status.ok()) status = CheckMapHash(hash, sha256);
  if (!status.ok()) return status;
  return bytes;
}

absl::StatusOr<std::shared_ptr<const RadarMap>> MapOf(std::vector<std::byte> bytes) {
  absl::StatusOr<std::shared_ptr<const RadarMap>> map = RadarMap::FromBytes(std::move(bytes));
  if (!map.ok()) return map;
  if (absl::Status status = (*map)->Verify(); !status.ok()) return status;
  return map;
}

absl::StatusOr<std::shared_ptr<const RadarMap>> ReadMap(const std::filesystem::path& path,
                                                        absl::string_view sha256) {
  absl::StatusOr<std::vector<std::byte>> bytes = ReadMapFile(path, sha256);
  if (!bytes.ok()) return bytes.status();
  return MapOf(*std::move(bytes));
}

absl::Status CheckMapFile(const std::filesystem::path& path, absl::string_view sha256,
                          absl::FunctionRef<bool(std::size_t)> pace) {
  const absl::StatusOr<FileDescriptor> file = OpenToRead(path);
  if (!file.ok()) return file.status();
  // What the disk has counts, not what the system still remembers of it.
  posix_fadvise(file->get(), 0, 0, POSIX_FADV_DONTNEED);
  std::vector<std::byte> piece(kPiece_bytes);
  Sha256 hash;
  while (true) {
    const absl::StatusOr<std::size_t> size = ReadUpTo(*file, piece);
    if (!size.ok()) return size.status();
    if (*size == 0) return CheckMapHash(hash, sha256);
    hash.Update(std::span(piece).first(*size));
    if (!pace(*size)) return absl::CancelledError("stopped");
  }
}

}  // namespace dcloc::server
