#include "server/maps/store/copy_map_file.h"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "server/base/files.h"
#include "server/base/sha256.h"
#include "server/maps/store/read_map.h"

namespace dcloc::server {
namespace {

constexpr std::size_t kCopyPiece_bytes = std::size_t{1} << 20;

absl::Status CopyBytes(const FileDescriptor& from, const FileDescriptor& to,
                       absl::string_view sha256, absl::FunctionRef<bool(std::size_t)> pace) {
  std::vector<std::byte> buffer(kCopyPiece_bytes);
  Sha256 hash;
  while (true) {
    const absl::StatusOr<std::size_t> size = ReadUpTo(from, buffer);
    if (!size.ok()) return size.status();
    if (*size == 0) break;
    const auto piece = std::span(buffer).first(*size);
    hash.Update(piece);
    if (absl::Status status = WriteAll(to, piece); !status.ok()) return status;
    if (!pace(*size)) return absl::CancelledError("stopped");
  }
  absl::Status status = CheckMapHash(hash, sha256);
  return status.ok() ? Sync(to) : status;
}

}  // namespace

absl::Status CopyMapFile(const std::filesystem::path& from, const std::filesystem::path& to,
                         absl::string_view sha256, absl::FunctionRef<bool(std::size_t)> pace) {
  const absl::StatusOr<FileDescriptor> source = OpenToRead(from);
  if (!source.ok()) return source.status();
  const std::filesystem::path partial = to.string() + ".partial";
  const absl::StatusOr<FileDescriptor> target = OpenOrCreate(partial);
  absl::Status status = target.status();
  if (status.ok()) status = Truncate(*target, 0);
  if (status.ok()) status = CopyBytes(*source, *target, sha256, pace);
  if (status.ok()) status = MoveFile(partial, to);
  if (status.ok()) return SyncFolder(to.parent_path());
  RemoveFile(partial).IgnoreError();
  return status;
}

}  // namespace dcloc::server
