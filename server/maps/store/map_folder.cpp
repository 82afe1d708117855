#include "server/maps/store/map_folder.h"

#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/base/files.h"
#include "server/base/sha256.h"

namespace dcloc::server {
namespace {

constexpr char kMapExtension[] = ".dcmap";
/// Files are spread over folders by the first digits of their hash.
constexpr std::size_t kSpreadDigits = 2;

}  // namespace

MapFolder::MapFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

absl::StatusOr<std::unique_ptr<MapFolder>> MapFolder::Open(const std::filesystem::path& folder) {
  if (absl::Status status = CreateFolders(folder); !status.ok()) return status;
  return std::unique_ptr<MapFolder>(new MapFolder(folder));
}

std::filesystem::path MapFolder::PathOf(absl::string_view sha256) const {
  return folder_ / std::string(sha256.substr(0, kSpreadDigits)) /
         absl::StrCat(sha256, kMapExtension);
}

absl::Status MapFolder::Keep(const std::filesystem::path& path, absl::string_view sha256) {
  const std::filesystem::path target = PathOf(sha256);
  if (absl::Status status = CreateFolders(target.parent_path()); !status.ok()) return status;
  std::error_code error;
  std::filesystem::rename(path, target, error);
  if (error) return FileError(error, target);
  absl::Status status = SyncFolder(target.parent_path());
  status.Update(SyncFolder(folder_));
  return status;
}

absl::StatusOr<std::shared_ptr<const RadarMap>> MapFolder::Open(absl::string_view sha256) {
  return RadarMap::Open(PathOf(sha256));
}

absl::Status MapFolder::Remove(absl::string_view sha256) { return RemoveFile(PathOf(sha256)); }

absl::StatusOr<std::int64_t> MapFolder::SizeOf(absl::string_view sha256) {
  return FileSize(PathOf(sha256));
}

absl::StatusOr<std::vector<std::string>> MapFolder::List() {
  std::vector<std::string> hashes;
  std::error_code error;
  std::filesystem::recursive_directory_iterator entry(folder_, error);
  for (; !error && entry != std::filesystem::end(entry); entry.increment(error)) {
    const std::string stem = entry->path().stem().string();
    if (entry->path().extension() == kMapExtension && IsSha256(stem)) hashes.push_back(stem);
  }
  if (error) return FileError(error, folder_);
  return hashes;
}

}  // namespace dcloc::server
