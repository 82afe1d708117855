#include "server/maps/store/map_cache.h"

#include <sys/stat.h>
#include <unistd.h>

#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/base/files.h"
#include "server/base/status.h"
#include "server/maps/store/cache_folder.h"
#include "server/maps/store/map_folder.h"
#include "server/maps/store/read_map.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {

absl::StatusOr<std::unique_ptr<MapCache>> MapCache::Open(const std::filesystem::path& folder,
                                                         std::int64_t max_bytes) {
  absl::StatusOr<CacheFolder> opened = CacheFolder::Lock(folder);
  std::unique_ptr<MapCache> cache(new MapCache(folder, max_bytes));
  if (absl::IsUnavailable(opened.status())) return cache;
  if (!opened.ok()) return opened.status();
  const absl::StatusOr<CacheRoom> room = opened->MakeRoom(0, max_bytes);
  if (!room.ok()) return room.status();
  cache->counts_.size_bytes = room->used_bytes;
  return cache;
}

absl::StatusOr<std::vector<std::byte>> MapCache::Read(absl::string_view sha256) {
  const std::filesystem::path path = CacheFolder::PathIn(folder_, sha256);
  absl::StatusOr<FileDescriptor> file = OpenToRead(path);
  if (!file.ok()) {
    ++counts_.misses;
    return absl::NotFoundError("not in the cache");
  }
  MarkUsed(*file);
  absl::StatusOr<std::vector<std::byte>> bytes = ReadMapFile(*file, sha256);
  if (bytes.ok()) ++counts_.hits;
  if (bytes.ok() || absl::IsResourceExhausted(bytes.status())) return bytes;
  ++counts_.misses;
  ++counts_.damaged;
  spdlog::warn("copy of a map file damaged, it is removed sha256={} reason={}", std::string(sha256),
               Quoted(bytes.status().message()));
  Remove(sha256);
  return absl::NotFoundError("was damaged in the cache");
}

void MapCache::Write(absl::string_view sha256, std::span<const std::byte> bytes) {
  const absl::Status status = TryWrite(sha256, bytes);
  if (status.ok()) return;
  ++counts_.not_stored;
  spdlog::warn("map file not kept in the cache sha256={} reason={}", std::string(sha256),
               Quoted(status.message()));
}

absl::Status MapCache::TryWrite(absl::string_view sha256, std::span<const std::byte> bytes) {
  const auto size_bytes = static_cast<std::int64_t>(bytes.size());
  if (size_bytes > max_bytes_) {
    return absl::ResourceExhaustedError(
        absl::StrFormat("it has %d bytes; map_cache_mib is %d", size_bytes, max_bytes_ >> 20));
  }
  absl::StatusOr<CachePart> part;
  {
    absl::StatusOr<CacheFolder> folder = CacheFolder::Lock(folder_);
    if (!folder.ok()) return folder.status();
    const absl::StatusOr<CacheRoom> room = folder->MakeRoom(size_bytes, max_bytes_);
    if (!room.ok()) return room.status();
    counts_.evictions += room->evicted_count;
    counts_.size_bytes = room->used_bytes;
    // Takes its room while the folder is locked, so that nobody else counts on that.
    part = CachePart::Begin(folder_, absl::StrCat(sha256, ".", getpid(), "-", ++part_count_),
                            size_bytes);
    if (!part.ok()) return part.status();
  }
  absl::Status status = WriteAll(part->file(), bytes);
  if (status.ok()) status = part->MoveTo(CacheFolder::PathIn(folder_, sha256));
  if (status.ok()) counts_.size_bytes += size_bytes;
  return status;
}

void MapCache::Remove(absl::string_view sha256) {
  const absl::Status status = RemoveFile(CacheFolder::PathIn(folder_, sha256));
  if (status.ok()) return;
  spdlog::warn("copy of a map file not removed sha256={} reason={}", std::string(sha256),
               Quoted(status.message()));
}

}  // namespace dcloc::server
