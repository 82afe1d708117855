#include "server/maps/store/cache_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <system_error>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/maps/store/map_folder.h"

namespace dcloc::server {
namespace {

namespace fs = std::filesystem;

constexpr char kCachePartExtension[] = ".part";
constexpr char kLock[] = "lock";
constexpr int kLockAttempts = 100;
constexpr std::chrono::milliseconds kLockPause(10);

struct Entry {
  fs::path path;
  std::int64_t size_bytes = 0;
  fs::file_time_type used;
};

/// Whether nobody reads or writes a file: then the result holds it.
absl::StatusOr<FileDescriptor> TakeAlone(const fs::path& path) {
  absl::StatusOr<FileDescriptor> file = OpenToRead(path);
  if (file.ok() && flock(file->get(), LOCK_EX | LOCK_NB) != 0) {
    return absl::UnavailableError("in use");
  }
  return file;
}

absl::StatusOr<std::vector<Entry>> EntriesIn(const fs::path& folder) {
  std::vector<Entry> entries;
  std::error_code error;
  fs::directory_iterator entry(folder, error);
  for (; !error && entry != fs::end(entry); entry.increment(error)) {
    const fs::path& path = entry->path();
    const bool part = path.extension() == kCachePartExtension;
    if (!part && MapFolder::HashOf(path).empty()) continue;
    if (part && TakeAlone(path).ok()) {
      if (absl::Status status = RemoveFile(path); !status.ok()) return status;
      continue;
    }
    // Another process may remove it meanwhile: then it takes no room.
    std::error_code gone;
    const auto size = entry->file_size(gone);
    const auto used = gone ? fs::file_time_type{} : entry->last_write_time(gone);
    if (!gone) entries.push_back({path, static_cast<std::int64_t>(size), used});
  }
  if (error) return FileError(error, folder);
  std::ranges::sort(entries, {}, &Entry::used);
  return entries;
}

absl::Status MakePrivate(const fs::path& folder) {
  if (absl::Status status = CreateFolders(folder); !status.ok()) return status;
  struct stat found {};
  constexpr mode_t kOwnerAlone = 0700;
  if (stat(folder.c_str(), &found) != 0) {
    return FileError(std::error_code(errno, std::generic_category()), folder);
  }
  if ((found.st_mode & 0777U) == kOwnerAlone || chmod(folder.c_str(), kOwnerAlone) == 0) {
    if (found.st_uid == geteuid()) return absl::OkStatus();
  }
  return absl::FailedPreconditionError(absl::StrCat("the cache's folder belongs to the user ",
                                                    found.st_uid, ", and this is ", geteuid()));
}

}  // namespace

absl::StatusOr<CacheFolder> CacheFolder::Lock(const fs::path& folder) {
  if (absl::Status status = MakePrivate(folder); !status.ok()) return status;
  absl::StatusOr<FileDescriptor> lock = OpenOrCreate(folder / kLock);
  if (!lock.ok()) return lock.status();
  // Not for ever: the one that has it may have been stopped.
  for (int attempt = 0; attempt < kLockAttempts; ++attempt) {
    if (flock(lock->get(), LOCK_EX | LOCK_NB) == 0) return CacheFolder(folder, *std::move(lock));
    std::this_thread::sleep_for(kLockPause);
  }
  return absl::UnavailableError("another process keeps the cache's folder locked");
}

absl::StatusOr<CacheRoom> CacheFolder::MakeRoom(std::int64_t size_bytes, std::int64_t max_bytes) {
  const absl::StatusOr<std::vector<Entry>> entries = EntriesIn(folder_);
  if (!entries.ok()) return entries.status();
  CacheRoom room;
  for (const Entry& entry : *entries) room.used_bytes += entry.size_bytes;
  for (const Entry& entry : *entries) {
    if (room.used_bytes + size_bytes <= max_bytes) return room;
    if (entry.path.extension() == kCachePartExtension || !TakeAlone(entry.path).ok()) continue;
    if (absl::Status status = RemoveFile(entry.path); !status.ok()) return status;
    room.used_bytes -= entry.size_bytes;
    ++room.evicted_count;
  }
  if (room.used_bytes + size_bytes <= max_bytes) return room;
  return absl::ResourceExhaustedError(absl::StrFormat(
      "files in use take %d bytes of the cache, and %d more are wanted; map_cache_mib is %d",
      room.used_bytes, size_bytes, max_bytes >> 20));
}

fs::path CacheFolder::PathIn(const fs::path& folder, absl::string_view sha256) {
  return folder / MapFolder::PathIn("", sha256).filename();
}

absl::StatusOr<CachePart> CachePart::Begin(const fs::path& folder, const std::string& name,
                                           std::int64_t size_bytes) {
  const fs::path path = folder / (name + kCachePartExtension);
  absl::StatusOr<FileDescriptor> file = OpenOrCreate(path);
  if (!file.ok()) return file.status();
  CachePart part(path, *std::move(file));
  if (flock(part.file_.get(), LOCK_EX | LOCK_NB) != 0) return absl::UnavailableError("in use");
  const int error = size_bytes == 0 ? 0 : posix_fallocate(part.file_.get(), 0, size_bytes);
  if (error != 0) return FileError(std::error_code(error, std::generic_category()), path);
  return part;
}

CachePart& CachePart::operator=(CachePart&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(file_, other.file_);
  return *this;
}

CachePart::~CachePart() {
  if (!path_.empty()) RemoveFile(path_).IgnoreError();
}

absl::Status CachePart::MoveTo(const fs::path& path) {
  absl::Status status = MoveFile(path_, path);
  if (status.ok()) path_.clear();
  return status;
}

void MarkUsed(const FileDescriptor& file) {
  flock(file.get(), LOCK_SH | LOCK_NB);
  futimens(file.get(), nullptr);
}

}  // namespace dcloc::server
