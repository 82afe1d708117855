#include "server/maps/store/incoming_files.h"

#include <span>
#include <system_error>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"

namespace dcloc::server {
namespace {

constexpr char kPartExtension[] = ".part";
/// Between tenant and hash; in no tenant's name.
constexpr char kSeparator[] = "@";

bool IsOurs(const std::filesystem::path& path) {
  const std::string stem = path.stem().string();
  const std::size_t at = stem.find(kSeparator);
  return path.extension() == kPartExtension && at != std::string::npos &&
         IsSha256(absl::string_view(stem).substr(at + 1));
}

/// Of the folder's files.
absl::StatusOr<std::vector<std::filesystem::path>> PathsIn(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> paths;
  std::error_code error;
  std::filesystem::directory_iterator entry(folder, error);
  for (; !error && entry != std::filesystem::end(entry); entry.increment(error)) {
    paths.push_back(entry->path());
  }
  if (error) return FileError(error, folder);
  return paths;
}

}  // namespace

absl::StatusOr<IncomingFile::Hold> IncomingFile::Lock() const {
  Hold hold(owner_->mutex);
  if (owner_->number == number_) return hold;
  return absl::AbortedError("another call has begun to upload the same file");
}

absl::Status IncomingFile::BeginAt(std::int64_t offset_bytes) {
  absl::StatusOr<FileDescriptor> file = OpenOrCreate(path_);
  if (!file.ok()) return file.status();
  if (absl::Status status = Truncate(*file, offset_bytes); !status.ok()) return status;
  std::vector<std::byte> buffer(std::size_t{1} << 20);
  while (true) {
    const absl::StatusOr<std::size_t> size = ReadUpTo(*file, buffer);
    if (!size.ok()) return size.status();
    if (*size == 0) break;
    hash_.Update(std::span(buffer).first(*size));
    hashed_bytes_ += static_cast<std::int64_t>(*size);
  }
  descriptor_.emplace(*std::move(file));
  return absl::OkStatus();
}

absl::Status IncomingFile::Write(absl::string_view bytes) {
  const auto data = std::as_bytes(std::span(bytes.data(), bytes.size()));
  if (absl::Status status = WriteAll(*descriptor_, data); !status.ok()) return status;
  hash_.Update(data);
  hashed_bytes_ += static_cast<std::int64_t>(data.size());
  return absl::OkStatus();
}

absl::StatusOr<std::string> IncomingFile::Finish() {
  if (absl::Status status = Sync(*descriptor_); !status.ok()) return status;
  return hash_.Finish();
}

absl::StatusOr<std::unique_ptr<IncomingFiles>> IncomingFiles::Open(
    const std::filesystem::path& folder) {
  if (absl::Status status = CreateFolders(folder); !status.ok()) return status;
  std::unique_ptr<IncomingFiles> files(new IncomingFiles(folder));
  const absl::StatusOr<std::vector<std::filesystem::path>> paths = PathsIn(folder);
  if (!paths.ok()) return paths.status();
  for (const std::filesystem::path& path : *paths) {
    if (IsOurs(path)) continue;
    if (absl::Status status = RemoveFile(path); !status.ok()) return status;
    ++files->removed_count_;
  }
  return files;
}

std::filesystem::path IncomingFiles::PathOf(absl::string_view tenant,
                                            absl::string_view sha256) const {
  return folder_ / absl::StrCat(tenant, kSeparator, sha256, kPartExtension);
}

IncomingFile IncomingFiles::Take(absl::string_view tenant, absl::string_view sha256) {
  const std::filesystem::path path = PathOf(tenant, sha256);
  std::shared_ptr<IncomingFile::Owner> owner;
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(owners_, [](const auto& entry) { return entry.second.expired(); });
    std::weak_ptr<IncomingFile::Owner>& known = owners_[path];
    owner = known.lock();
    if (owner == nullptr) known = owner = std::make_shared<IncomingFile::Owner>();
  }
  const std::lock_guard lock(owner->mutex);
  const std::int64_t number = ++owner->number;
  return IncomingFile(path, owner, number);
}

absl::StatusOr<std::int64_t> IncomingFiles::DurableSize(absl::string_view tenant,
                                                        absl::string_view sha256) const {
  const std::filesystem::path path = PathOf(tenant, sha256);
  absl::StatusOr<std::int64_t> size = FileSize(path);
  if (!size.ok() || *size == 0) return size;
  absl::Status status = SyncFile(path);
  if (status.ok()) status = SyncFolder(folder_);
  if (status.ok()) return size;
  // It may have gone into the store meanwhile.
  const absl::StatusOr<std::int64_t> size_now = FileSize(path);
  if (size_now.ok() && *size_now == 0) return 0;
  // What a sync did not write may be gone, though it can be read until it leaves the memory.
  RemoveFile(path).IgnoreError();
  return status;
}

absl::StatusOr<std::map<std::string, std::int64_t>> IncomingFiles::SizesOf(
    absl::string_view tenant) const {
  const absl::StatusOr<std::vector<std::filesystem::path>> paths = PathsIn(folder_);
  if (!paths.ok()) return paths.status();
  const std::string prefix = absl::StrCat(tenant, kSeparator);
  std::map<std::string, std::int64_t> sizes;
  for (const std::filesystem::path& path : *paths) {
    const std::string stem = path.stem().string();
    if (!IsOurs(path) || !absl::StartsWith(stem, prefix)) continue;
    const absl::StatusOr<std::int64_t> size = FileSize(path);
    if (!size.ok()) return size.status();
    sizes[stem.substr(prefix.size())] = *size;
  }
  return sizes;
}

absl::StatusOr<int> IncomingFiles::RemoveStale(std::chrono::nanoseconds served,
                                               std::chrono::nanoseconds limit) {
  const std::lock_guard lock(mutex_);
  absl::StatusOr<std::vector<std::filesystem::path>> paths = PathsIn(folder_);
  if (!paths.ok()) return paths.status();
  std::erase_if(*paths, [this](const std::filesystem::path& path) {
    const auto owner = owners_.find(path);
    return owner != owners_.end() && !owner->second.expired();
  });
  return ages_.RemoveAged(served, limit, *paths);
}

absl::StatusOr<int> IncomingFiles::Count() const {
  const absl::StatusOr<std::vector<std::filesystem::path>> paths = PathsIn(folder_);
  if (!paths.ok()) return paths.status();
  return static_cast<int>(paths->size());
}

}  // namespace dcloc::server
