#include "server/maps/store/kept_files.h"

#include <algorithm>
#include <cstddef>
#include <span>
#include <system_error>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/base/files.h"
#include "server/base/sha256.h"
#include "server/maps/store/copy_map_file.h"
#include "server/maps/store/read_map.h"

namespace dcloc::server {
namespace {

constexpr std::int64_t kPiece_bytes = std::int64_t{4} << 20;
constexpr char kPartial[] = ".partial";  ///< what CopyMapFile has not finished

bool GoOn(std::size_t /*size*/) { return true; }

/// Writes the whole object to `path`, and compares its hash.
absl::Status Download(ObjectStore& objects, const std::string& key, absl::string_view sha256,
                      const std::filesystem::path& path) {
  const absl::StatusOr<std::int64_t> size_bytes = objects.SizeOf(key);
  if (!size_bytes.ok()) return size_bytes.status();
  const absl::StatusOr<FileDescriptor> file = OpenOrCreate(path);
  absl::Status status = file.ok() ? Truncate(*file, 0) : file.status();
  std::vector<std::byte> buffer(static_cast<std::size_t>(std::min(*size_bytes, kPiece_bytes)));
  Sha256 hash;
  for (std::int64_t offset = 0; status.ok() && offset < *size_bytes; offset += kPiece_bytes) {
    const auto piece = std::span(buffer).first(
        static_cast<std::size_t>(std::min(kPiece_bytes, *size_bytes - offset)));
    status = objects.Read(key, offset, piece);
    hash.Update(piece);
    if (status.ok()) status = WriteAll(*file, piece);
  }
  return status.ok() ? CheckMapHash(hash, sha256) : status;
}

}  // namespace

absl::StatusOr<std::unique_ptr<KeptFolder>> KeptFolder::Open(const std::filesystem::path& folder) {
  if (absl::Status status = CreateFolders(folder); !status.ok()) return status;
  return std::unique_ptr<KeptFolder>(new KeptFolder(folder));
}

absl::Status KeptFolder::Keep(const std::filesystem::path& path, absl::string_view name,
                              absl::string_view sha256) {
  absl::Status status = CopyMapFile(path, PathOf(name), sha256, &GoOn);
  return status.ok() ? RemoveFile(path) : status;
}

absl::Status KeptFolder::Fetch(absl::string_view name, absl::string_view sha256,
                               const std::filesystem::path& path) {
  return CopyMapFile(PathOf(name), path, sha256, &GoOn);
}

absl::Status KeptFolder::Remove(absl::string_view name) {
  absl::Status status = RemoveFile(PathOf(name));
  return status.ok() ? RemoveFile(PathOf(absl::StrCat(name, kPartial))) : status;
}

absl::StatusOr<std::map<std::string, std::int64_t>> KeptFolder::List() {
  std::map<std::string, std::int64_t> files;
  std::error_code error;
  std::filesystem::directory_iterator entry(folder_, error);
  for (; !error && entry != std::filesystem::end(entry); entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    const std::string whole(name.substr(0, name.find('.')));
    std::error_code gone;
    const auto size = entry->file_size(gone);
    if (!gone) files.emplace(whole, static_cast<std::int64_t>(size));
  }
  if (error) return FileError(error, folder_);
  return files;
}

std::string KeptObjects::KeyOf(absl::string_view name) const { return absl::StrCat(prefix_, name); }

absl::Status KeptObjects::Keep(const std::filesystem::path& path, absl::string_view name,
                               absl::string_view sha256) {
  const absl::StatusOr<FileDescriptor> file = OpenToRead(path);
  if (!file.ok()) return file.status();
  const absl::StatusOr<std::int64_t> size_bytes = FileSize(*file);
  if (!size_bytes.ok()) return size_bytes.status();
  absl::Status status = objects_->Put(KeyOf(name), *file, *size_bytes, sha256);
  return status.ok() ? RemoveFile(path) : status;
}

absl::Status KeptObjects::Fetch(absl::string_view name, absl::string_view sha256,
                                const std::filesystem::path& path) {
  const std::string key = KeyOf(name);
  absl::Status status = Download(*objects_, key, sha256, path);
  // On their way the bytes may have changed as well.
  if (absl::IsDataLoss(status)) status = Download(*objects_, key, sha256, path);
  if (!status.ok()) RemoveFile(path).IgnoreError();
  return status;
}

absl::Status KeptObjects::Remove(absl::string_view name) { return objects_->Remove(KeyOf(name)); }

absl::StatusOr<std::map<std::string, std::int64_t>> KeptObjects::List() {
  return objects_->List(prefix_);
}

}  // namespace dcloc::server
