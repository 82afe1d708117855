#include "server/maps/store/map_folder.h"

#include <system_error>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "server/base/files.h"
#include "server/base/sha256.h"
#include "server/maps/store/copy_map_file.h"
#include "server/maps/store/read_map.h"

namespace dcloc::server {
namespace {

constexpr char kMapExtension[] = ".dcmap";
/// Files are spread over folders by the first digits of their hash.
constexpr std::size_t kSpreadDigits = 2;

/// Of a folder, which need not be there.
absl::StatusOr<std::vector<std::filesystem::path>> FilesIn(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> paths;
  std::error_code error;
  std::filesystem::directory_iterator entry(folder, error);
  for (; !error && entry != std::filesystem::end(entry); entry.increment(error)) {
    if (entry->is_regular_file(error)) paths.push_back(entry->path());
  }
  if (error && error != std::errc::no_such_file_or_directory) return FileError(error, folder);
  return paths;
}

}  // namespace

absl::StatusOr<std::unique_ptr<MapFolder>> MapFolder::Open(const std::filesystem::path& folder,
                                                           const std::filesystem::path& quarantine,
                                                           const std::string& copier) {
  absl::Status status = CreateFolders(folder);
  status.Update(CreateFolders(quarantine));
  if (!status.ok()) return status;
  return std::unique_ptr<MapFolder>(new MapFolder(folder, quarantine, copier));
}

std::filesystem::path MapFolder::PathIn(const std::filesystem::path& folder,
                                        absl::string_view sha256) {
  return folder / std::string(sha256.substr(0, kSpreadDigits)) /
         absl::StrCat(sha256, kMapExtension);
}

absl::Status MapFolder::Keep(const std::filesystem::path& path, absl::string_view sha256) {
  const std::filesystem::path target = PathOf(sha256);
  absl::Status status = CreateFolders(target.parent_path());
  // No file can be moved onto a folder that somebody has put there.
  std::error_code error;
  const bool is_folder = std::filesystem::is_directory(target, error);
  if (status.ok() && is_folder) status = Quarantine(sha256);
  if (!status.ok()) return status;
  status = copier_.empty() ? MoveFile(path, target) : Copy(path, sha256);
  if (!status.ok()) return status;
  status = SyncFolder(target.parent_path());
  status.Update(SyncFolder(folder_));
  return status;
}

absl::Status MapFolder::Copy(const std::filesystem::path& path, absl::string_view sha256) const {
  const std::filesystem::path target = PathOf(sha256);
  const std::filesystem::path part = absl::StrCat(target.string(), ".", copier_);
  absl::Status status = RemoveParts(sha256);
  if (status.ok()) status = CopyMapFile(path, part, sha256, [](std::size_t) { return true; });
  if (status.ok()) status = MoveFile(part, target);
  return status.ok() ? RemoveFile(path) : status;
}

absl::Status MapFolder::RemoveParts(absl::string_view sha256) const {
  if (copier_.empty()) return absl::OkStatus();
  const std::filesystem::path whole = PathOf(sha256);
  const std::string prefix = absl::StrCat(whole.filename().string(), ".");
  const auto paths = FilesIn(whole.parent_path());
  if (!paths.ok()) return paths.status();
  for (const std::filesystem::path& path : *paths) {
    if (!absl::StartsWith(path.filename().string(), prefix)) continue;
    if (absl::Status status = RemoveFile(path); !status.ok()) return status;
  }
  return absl::OkStatus();
}

std::string MapFolder::HashOf(const std::filesystem::path& path) {
  std::string stem = path.stem().string();
  return path.extension() == kMapExtension && IsSha256(stem) ? std::move(stem) : "";
}

absl::StatusOr<std::vector<std::byte>> MapFolder::Read(absl::string_view sha256) {
  return ReadMapFile(PathOf(sha256), sha256);
}

absl::Status MapFolder::Check(absl::string_view sha256, absl::FunctionRef<bool(std::size_t)> pace) {
  return CheckMapFile(PathOf(sha256), sha256, pace);
}

absl::Status MapFolder::Remove(absl::string_view sha256) {
  absl::Status status = RemoveFile(PathOf(sha256));
  return status.ok() ? RemoveParts(sha256) : status;
}

absl::Status MapFolder::Quarantine(absl::string_view sha256) {
  const std::filesystem::path from = PathOf(sha256);
  // One of that name may have been there for long.
  absl::Status status = ages_.Forget(from.filename().string());
  if (status.ok()) status = MoveFile(from, quarantine_ / from.filename());
  if (status.ok()) status = SyncFolder(quarantine_);
  if (status.ok()) status = SyncFolder(from.parent_path());
  return status.ok() ? RemoveParts(sha256) : status;
}

absl::StatusOr<int> MapFolder::RemoveExpiredQuarantine(std::chrono::nanoseconds served,
                                                       std::chrono::nanoseconds limit) {
  const auto paths = FilesIn(quarantine_);
  if (!paths.ok()) return paths.status();
  return ages_.RemoveAged(served, limit, *paths);
}

absl::StatusOr<int> MapFolder::QuarantinedCount() {
  const auto paths = FilesIn(quarantine_);
  if (!paths.ok()) return paths.status();
  return static_cast<int>(paths->size());
}

absl::StatusOr<std::int64_t> MapFolder::SizeOf(absl::string_view sha256) {
  return FileSize(PathOf(sha256));
}

absl::StatusOr<std::vector<std::string>> MapFolder::List() {
  std::vector<std::string> hashes;
  std::error_code error;
  std::filesystem::recursive_directory_iterator entry(folder_, error);
  for (; !error && entry != std::filesystem::end(entry); entry.increment(error)) {
    std::string hash = HashOf(entry->path());
    if (!hash.empty()) hashes.push_back(std::move(hash));
  }
  if (error && error != std::errc::no_such_file_or_directory) return FileError(error, folder_);
  return hashes;
}

}  // namespace dcloc::server
