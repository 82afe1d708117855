#include "server/maps/store/cached_map_files.h"

#include <utility>

namespace dcloc::server {

CachedMapFiles::CachedMapFiles(std::unique_ptr<MapFiles> files, std::shared_ptr<MapCache> cache)
    : files_(std::move(files)), cache_(std::move(cache)) {}

absl::Status CachedMapFiles::Keep(const std::filesystem::path& path, absl::string_view sha256) {
  return files_->Keep(path, sha256);
}

absl::StatusOr<std::vector<std::byte>> CachedMapFiles::Read(absl::string_view sha256) {
  absl::StatusOr<std::vector<std::byte>> bytes = cache_->Read(sha256);
  if (!absl::IsNotFound(bytes.status())) return bytes;
  bytes = files_->Read(sha256);
  if (bytes.ok()) cache_->Write(sha256, *bytes);
  return bytes;
}

absl::StatusOr<std::shared_ptr<const RadarMap>> CachedMapFiles::Open(absl::string_view sha256) {
  return openings_.Do(std::string(sha256), [&] { return MapFiles::Open(sha256); });
}

absl::Status CachedMapFiles::Check(absl::string_view sha256,
                                   absl::FunctionRef<bool(std::size_t)> pace) {
  return files_->Check(sha256, pace);
}

absl::Status CachedMapFiles::Remove(absl::string_view sha256) {
  cache_->Remove(sha256);
  return files_->Remove(sha256);
}

absl::Status CachedMapFiles::Quarantine(absl::string_view sha256) {
  cache_->Remove(sha256);
  return files_->Quarantine(sha256);
}

absl::StatusOr<int> CachedMapFiles::RemoveExpiredQuarantine(std::chrono::nanoseconds served,
                                                            std::chrono::nanoseconds limit) {
  return files_->RemoveExpiredQuarantine(served, limit);
}

absl::StatusOr<int> CachedMapFiles::QuarantinedCount() { return files_->QuarantinedCount(); }

absl::StatusOr<std::int64_t> CachedMapFiles::SizeOf(absl::string_view sha256) {
  return files_->SizeOf(sha256);
}

absl::StatusOr<std::vector<std::string>> CachedMapFiles::List() { return files_->List(); }

}  // namespace dcloc::server
