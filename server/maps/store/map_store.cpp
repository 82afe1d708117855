#include "server/maps/store/map_store.h"

#include <limits>
#include <span>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/base/sha256.h"
#include "server/base/status.h"
#include "server/maps/catalogue/coverage.h"
#include "server/maps/catalogue/sqlite_catalogue.h"
#include "server/maps/store/map_folder.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

absl::Status InUseError(absl::string_view map_name, std::int64_t version) {
  return absl::FailedPreconditionError(
      absl::StrFormat("version %d of map %s is in use; its sessions and downloads must end first",
                      version, Quoted(map_name)));
}

/// Where a vehicle lies among all, [0, 1): the same on each server and for each version, so that a
/// growing share keeps the vehicles that it had.
double ShareOf(absl::string_view map_name, absl::string_view vehicle_id) {
  Sha256 hash;
  const std::string text = absl::StrCat(map_name, "\n", vehicle_id);
  hash.Update(std::as_bytes(std::span(text)));
  constexpr int kDigits = 8;
  const std::string digits = hash.Finish().substr(0, kDigits);
  constexpr double kScale = 1.0 / 4294967296.0;  // 16^8
  return kScale * static_cast<double>(std::stoul(digits, nullptr, 16));
}

}  // namespace

/// One version in memory. Who asks first loads it, who asks meanwhile waits for that.
struct MapStore::Loaded {
  std::mutex mutex;
  std::shared_ptr<const RadarMap> map;

  /// Gives whether it was there already.
  absl::StatusOr<bool> Load(MapFiles& files, absl::string_view sha256) {
    const std::lock_guard lock(mutex);
    if (map != nullptr) return true;
    absl::StatusOr<std::shared_ptr<const RadarMap>> opened = files.Open(sha256);
    absl::Status status = opened.status();
    // Also brings the whole file into memory before the first scan needs it.
    if (status.ok()) status = (*opened)->Verify();
    if (status.ok()) {
      map = *std::move(opened);
      return false;
    }
    if (!absl::IsNotFound(status) && !absl::IsDataLoss(status)) return status;
    spdlog::error("map file not loaded reason={}", Quoted(status.message()));
    return absl::DataLossError("the version's file is missing or damaged on the server");
  }
};

MapStore::MapStore(FileDescriptor lock, std::unique_ptr<Catalogue> catalogue,
                   std::unique_ptr<MapFiles> files, std::unique_ptr<IncomingFiles> incoming,
                   std::unique_ptr<BuildLedger> builds, const MapStoreOptions& options)
    : lock_(std::move(lock)),
      catalogue_(std::move(catalogue)),
      files_(std::move(files)),
      incoming_(std::move(incoming)),
      builds_(std::move(builds)),
      unfinished_upload_timeout_(options.unfinished_upload_timeout),
      warm_(options.max_warm_bytes) {}

absl::StatusOr<std::unique_ptr<MapStore>> MapStore::Open(const std::filesystem::path& folder,
                                                         const MapStoreOptions& options) {
  if (absl::Status status = CreateFolders(folder); !status.ok()) return status;
  absl::StatusOr<FileDescriptor> lock = LockFile(folder / "lock");
  if (!lock.ok()) return lock.status();
  absl::StatusOr<std::unique_ptr<SqliteCatalogue>> catalogue =
      SqliteCatalogue::Open(folder / "catalogue.sqlite");
  if (!catalogue.ok()) return catalogue.status();
  absl::StatusOr<std::unique_ptr<MapFolder>> files = MapFolder::Open(folder / "maps");
  if (!files.ok()) return files.status();
  absl::StatusOr<std::unique_ptr<IncomingFiles>> incoming =
      IncomingFiles::Open(folder / "incoming");
  if (!incoming.ok()) return incoming.status();
  absl::StatusOr<std::unique_ptr<BuildLedger>> builds = BuildLedger::Open(folder / "builds");
  if (!builds.ok()) return builds.status();
  std::unique_ptr<MapStore> store(new MapStore(*std::move(lock), *std::move(catalogue),
                                               *std::move(files), *std::move(incoming),
                                               *std::move(builds), options));
  absl::StatusOr<StoreReport> report =
      CheckStore(*store->catalogue_, *store->files_, *store->incoming_,
                 std::chrono::system_clock::now() - options.unfinished_upload_timeout);
  if (!report.ok()) return report.status();
  Log(*report);
  store->report_ = *std::move(report);
  return store;
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
  const absl::StatusOr<bool> was_in_memory = loaded->Load(*files_, record->sha256);
  if (!was_in_memory.ok()) return was_in_memory.status();
  const RadarMap* map = loaded->map.get();
  LoadedMap result{.record = *std::move(record),
                   .map = std::shared_ptr<const RadarMap>(std::move(loaded), map),
                   .was_in_memory = *was_in_memory};
  const std::lock_guard lock(mutex_);
  // Gone or relabelled meanwhile: what was loaded is still what was asked for.
  const absl::StatusOr<MapRecord> now = catalogue_->GetMap(map_name);
  if (now.ok()) KeepWarm(*now, result);
  return result;
}

absl::StatusOr<LoadedMap> MapStore::AcquireFor(absl::string_view map_name,
                                               absl::string_view vehicle_id) {
  const absl::StatusOr<MapRecord> map = catalogue_->GetMap(map_name);
  if (!map.ok()) return map.status();
  if (map->canary_version != 0 && ShareOf(map_name, vehicle_id) < map->canary_share) {
    absl::StatusOr<LoadedMap> canary = Acquire(map_name, map->canary_version);
    if (canary.ok()) return canary;
    spdlog::error("canary not loaded, the active version serves map={} version={} reason={}",
                  std::string(map_name), map->canary_version, Quoted(canary.status().message()));
  }
  return Acquire(map_name, 0);
}

absl::StatusOr<LoadedMap> MapStore::Add(const std::filesystem::path& path,
                                        absl::string_view map_name, absl::string_view sha256,
                                        std::shared_ptr<const RadarMap> map) {
  const std::vector<CoverageBox> coverage = CoverageOf(*map);
  const std::lock_guard lock(mutex_);
  // The file first: a file without a row is a leftover, a row without a file would be a lie.
  if (absl::Status status = files_->Keep(path, sha256); !status.ok()) return status;
  absl::StatusOr<MapVersionRecord> record =
      catalogue_->AddVersion(map_name, sha256, map->info(), coverage);
  if (!record.ok()) {
    RemoveFileUnlessNeeded(sha256).IgnoreError();
    return record.status();
  }
  // Unless it is there already: a map that has this file gives the version that has it.
  std::weak_ptr<Loaded>& entry = loaded_[Key(map_name, record->version)];
  if (entry.expired()) {
    const auto loaded = std::make_shared<Loaded>();
    loaded->map = map;
    map = std::shared_ptr<const RadarMap>(loaded, map.get());
    entry = loaded;
  }
  return LoadedMap{.record = *std::move(record), .map = std::move(map)};
}

absl::StatusOr<MapVersionRecord> MapStore::AddStored(absl::string_view prefix,
                                                     absl::string_view map_name,
                                                     absl::string_view sha256) {
  const absl::Status missing =
      absl::NotFoundError(absl::StrCat("header.sha256 is ", sha256, "; no map has that file"));
  const absl::StatusOr<bool> stored = HasStored(prefix, sha256);
  if (!stored.ok()) return stored.status();
  if (!*stored) return missing;
  const absl::StatusOr<std::shared_ptr<const RadarMap>> map = files_->Open(sha256);
  if (!map.ok()) return map.status();
  const std::vector<CoverageBox> coverage = CoverageOf(**map);
  const std::lock_guard lock(mutex_);
  // Its version may have been deleted meanwhile.
  const absl::StatusOr<std::int64_t> size = catalogue_->SizeOfFile(prefix, sha256);
  if (!size.ok()) return size.status();
  if (*size == 0) return missing;
  return catalogue_->AddVersion(map_name, sha256, (*map)->info(), coverage);
}

absl::StatusOr<bool> MapStore::HasStored(absl::string_view prefix, absl::string_view sha256) {
  const absl::StatusOr<std::int64_t> wanted = catalogue_->SizeOfFile(prefix, sha256);
  if (!wanted.ok()) return wanted.status();
  const absl::StatusOr<std::int64_t> size = files_->SizeOf(sha256);
  if (!size.ok()) return size.status();
  return *wanted != 0 && *size == *wanted;
}

absl::StatusOr<MapRecord> MapStore::Activate(absl::string_view map_name, std::int64_t version) {
  // Warm before any session can ask for it, and held until it is known to be the active one.
  const absl::StatusOr<LoadedMap> loaded = Acquire(map_name, version);
  if (!loaded.ok()) return loaded.status();
  const std::lock_guard lock(mutex_);
  if (absl::Status status = catalogue_->Activate(map_name, version); !status.ok()) return status;
  absl::StatusOr<MapRecord> map = catalogue_->GetMap(map_name);
  if (map.ok()) KeepWarm(*map, *loaded);
  return map;
}

absl::StatusOr<MapRecord> MapStore::RollBack(absl::string_view map_name) {
  const absl::StatusOr<MapRecord> map = catalogue_->GetMap(map_name);
  if (!map.ok()) return map.status();
  if (map->previous_version != 0) return Activate(map_name, map->previous_version);
  return absl::FailedPreconditionError(
      absl::StrCat("map ", Quoted(map_name), " has no version that was active before"));
}

absl::StatusOr<MapRecord> MapStore::SetCanary(absl::string_view map_name, std::int64_t version,
                                              double share) {
  LoadedMap loaded;
  if (version != 0) {
    absl::StatusOr<LoadedMap> acquired = Acquire(map_name, version);
    if (!acquired.ok()) return acquired.status();
    loaded = *std::move(acquired);
  }
  const std::lock_guard lock(mutex_);
  absl::Status status = catalogue_->SetCanary(map_name, version, share);
  if (!status.ok()) return status;
  absl::StatusOr<MapRecord> map = catalogue_->GetMap(map_name);
  if (!map.ok()) return map.status();
  KeepWarm(*map, loaded);
  return map;
}

absl::StatusOr<int> MapStore::RemoveStaleUploads(SystemTime now) {
  return incoming_->RemoveUntouchedSince(now - unfinished_upload_timeout_);
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
  warm_.KeepOnly(map_name, 0, 0);
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

void MapStore::KeepWarm(const MapRecord& map, const LoadedMap& loaded) {
  const std::int64_t version = loaded.record.version;
  if (version != 0 && (version == map.active_version || version == map.canary_version)) {
    warm_.Keep({map.name, version}, loaded.map,
               static_cast<std::int64_t>(loaded.record.info.size_bytes));
  }
  warm_.KeepOnly(map.name, map.active_version, map.canary_version);
}

bool MapStore::InUse(const Key& key) const {
  const auto entry = loaded_.find(key);
  if (entry == loaded_.end()) return false;
  return entry->second.use_count() > (warm_.Has(key) ? 1 : 0);
}

absl::Status MapStore::RemoveFileUnlessNeeded(absl::string_view sha256) {
  const absl::StatusOr<bool> needed = catalogue_->HasFile(sha256);
  if (!needed.ok()) return needed.status();
  return *needed ? absl::OkStatus() : files_->Remove(sha256);
}

}  // namespace dcloc::server
