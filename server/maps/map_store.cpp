#include "server/maps/map_store.h"

#include <limits>
#include <system_error>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/maps/map_folder.h"
#include "server/maps/sqlite_catalogue.h"
#include "server/status.h"

namespace dcloc::server {
namespace {

absl::Status InUseError(absl::string_view map_name, std::int64_t version) {
  return absl::FailedPreconditionError(
      absl::StrFormat("version %d of map %s is in use; its sessions and downloads must end first",
                      version, Quoted(map_name)));
}

}  // namespace

/// One version in memory. Who asks first loads it, who asks meanwhile waits for that.
struct MapStore::Loaded {
  std::mutex mutex;
  std::shared_ptr<const RadarMap> map;

  absl::Status Load(MapFiles& files, absl::string_view sha256) {
    const std::lock_guard lock(mutex);
    if (map != nullptr) return absl::OkStatus();
    absl::StatusOr<std::shared_ptr<const RadarMap>> opened = files.Open(sha256);
    if (!opened.ok()) return opened.status();
    // Also brings the whole file into memory before the first scan needs it.
    if (absl::Status status = (*opened)->Verify(); !status.ok()) return status;
    map = *std::move(opened);
    return absl::OkStatus();
  }
};

MapStore::MapStore(FileDescriptor lock, std::filesystem::path incoming_folder,
                   std::unique_ptr<Catalogue> catalogue, std::unique_ptr<MapFiles> files)
    : lock_(std::move(lock)),
      incoming_folder_(std::move(incoming_folder)),
      catalogue_(std::move(catalogue)),
      files_(std::move(files)) {}

absl::StatusOr<std::unique_ptr<MapStore>> MapStore::Open(const std::filesystem::path& folder) {
  const std::filesystem::path incoming_folder = folder / "incoming";
  if (absl::Status status = CreateFolders(incoming_folder); !status.ok()) return status;
  absl::StatusOr<FileDescriptor> lock = LockFile(folder / "lock");
  if (!lock.ok()) return lock.status();
  absl::StatusOr<std::unique_ptr<SqliteCatalogue>> catalogue =
      SqliteCatalogue::Open(folder / "catalogue.sqlite");
  if (!catalogue.ok()) return catalogue.status();
  absl::StatusOr<std::unique_ptr<MapFolder>> files = MapFolder::Open(folder / "maps");
  if (!files.ok()) return files.status();
  std::unique_ptr<MapStore> store(
      new MapStore(*std::move(lock), incoming_folder, *std::move(catalogue), *std::move(files)));
  if (absl::Status status = store->RemoveLeftovers(); !status.ok()) return status;
  return store;
}

absl::Status MapStore::RemoveLeftovers() {
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(incoming_folder_, error)) {
    std::filesystem::remove(entry.path(), error);
  }
  if (error) {
    return absl::InternalError(absl::StrCat(incoming_folder_.string(), ": ", error.message()));
  }
  const absl::StatusOr<std::vector<std::string>> hashes = files_->List();
  if (!hashes.ok()) return hashes.status();
  for (const std::string& sha256 : *hashes) {
    if (absl::Status status = RemoveFileUnlessNeeded(sha256); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::StatusOr<LoadedMap> MapStore::Acquire(absl::string_view map_name, std::int64_t version) {
  absl::StatusOr<MapVersionRecord> record;
  std::shared_ptr<Loaded> loaded;
  {
    const std::lock_guard lock(mutex_);
    record = catalogue_->GetVersion(map_name, version);
    if (!record.ok()) return record.status();
    std::erase_if(loaded_, [](const auto& entry) { return entry.second.expired(); });
    std::weak_ptr<Loaded>& entry = loaded_[Key(map_name, record->version)];
    loaded = entry.lock();
    if (loaded == nullptr) entry = loaded = std::make_shared<Loaded>();
  }
  if (absl::Status status = loaded->Load(*files_, record->sha256); !status.ok()) return status;
  const RadarMap* map = loaded->map.get();
  return LoadedMap{.record = *std::move(record),
                   .map = std::shared_ptr<const RadarMap>(std::move(loaded), map)};
}

absl::StatusOr<MapVersionRecord> MapStore::Add(const std::filesystem::path& path,
                                               absl::string_view map_name, absl::string_view sha256,
                                               const MapInfo& info, bool activate) {
  const std::lock_guard lock(mutex_);
  // The file first: a file without a row is a leftover, a row without a file would be a lie.
  if (absl::Status status = files_->Keep(path, sha256); !status.ok()) return status;
  absl::StatusOr<MapVersionRecord> record =
      catalogue_->AddVersion(map_name, sha256, info, activate);
  if (!record.ok()) RemoveFileUnlessNeeded(sha256).IgnoreError();
  return record;
}

absl::Status MapStore::DeleteVersion(absl::string_view map_name, std::int64_t version) {
  const std::lock_guard lock(mutex_);
  const absl::StatusOr<MapVersionRecord> record = catalogue_->GetVersion(map_name, version);
  if (!record.ok()) return record.status();
  if (InUse(Key(map_name, version))) return InUseError(map_name, version);
  absl::Status status = catalogue_->DeleteVersion(map_name, version);
  return status.ok() ? RemoveFileUnlessNeeded(record->sha256) : status;
}

absl::Status MapStore::DeleteMap(absl::string_view map_name) {
  const std::lock_guard lock(mutex_);
  const absl::StatusOr<std::vector<MapVersionRecord>> versions = catalogue_->ListVersions(
      map_name, std::numeric_limits<std::int64_t>::max(), std::numeric_limits<int>::max());
  if (!versions.ok()) return versions.status();
  for (const MapVersionRecord& record : *versions) {
    if (InUse(Key(map_name, record.version))) return InUseError(map_name, record.version);
  }
  absl::Status status = catalogue_->DeleteMap(map_name);
  if (!status.ok()) return status;
  for (const MapVersionRecord& record : *versions) {
    status.Update(RemoveFileUnlessNeeded(record.sha256));
  }
  return status;
}

int MapStore::loaded_map_count() {
  const std::lock_guard lock(mutex_);
  int count = 0;
  for (const auto& [key, loaded] : loaded_) count += loaded.expired() ? 0 : 1;
  return count;
}

bool MapStore::InUse(const Key& key) const {
  const auto entry = loaded_.find(key);
  return entry != loaded_.end() && !entry->second.expired();
}

absl::Status MapStore::RemoveFileUnlessNeeded(absl::string_view sha256) {
  const absl::StatusOr<bool> needed = catalogue_->HasFile(sha256);
  if (!needed.ok()) return needed.status();
  return *needed ? absl::OkStatus() : files_->Remove(sha256);
}

}  // namespace dcloc::server
