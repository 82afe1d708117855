#include "server/maps/store/map_store.h"

#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/base/sha256.h"
#include "server/base/status.h"
#include "server/maps/catalogue/coverage.h"
#include "server/maps/store/orphan_file.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

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

/// Held like a file by who counts how long files have been in quarantine.
constexpr char kQuarantine[] = "quarantine";

}  // namespace

/// One file in memory. Who asks first loads it, who asks meanwhile waits for that.
struct MapStore::Loaded {
  const std::string sha256;
  std::mutex mutex;
  std::shared_ptr<const RadarMap> map;

  explicit Loaded(std::string file) : sha256(std::move(file)) {}

  /// Gives whether it was there already.
  absl::StatusOr<bool> Load(MapFiles& files) {
    const std::lock_guard lock(mutex);
    if (map != nullptr) return true;
    absl::StatusOr<std::shared_ptr<const RadarMap>> opened = files.Open(sha256);
    if (opened.ok()) {
      map = *std::move(opened);
      return false;
    }
    const absl::Status& status = opened.status();
    spdlog::error("map file not loaded sha256={} reason={}", sha256, Quoted(status.message()));
    if (!absl::IsNotFound(status) && !absl::IsDataLoss(status)) return status;
    return absl::DataLossError("the version's file is missing or damaged on the server");
  }
};

/// A version that someone here uses: its copy in memory, and what keeps it from being deleted.
struct MapStore::Use {
  Hold hold;
  std::shared_ptr<Loaded> loaded;
};

MapStore::MapStore(MapStoreParts parts, const MapStoreOptions& options)
    : parts_(std::move(parts)),
      options_(options),
      quota_(*parts_.catalogue, *parts_.incoming),
      warm_(options.max_warm_bytes) {}

absl::StatusOr<std::unique_ptr<MapStore>> MapStore::Open(MapStoreParts parts,
                                                         const MapStoreOptions& options) {
  absl::StatusOr<StoreReport> report = CheckStore(*parts.catalogue, *parts.files, *parts.incoming,
                                                  options.unfinished_upload_timeout, parts.holder);
  if (!report.ok()) return report.status();
  Log(*report);
  std::unique_ptr<MapStore> store(new MapStore(std::move(parts), options));
  store->report_ = *std::move(report);
  store->CountQuarantine();
  return store;
}

absl::StatusOr<LoadedMap> MapStore::Acquire(absl::string_view map_name, std::int64_t version) {
  absl::StatusOr<MapVersionRecord> record;
  absl::StatusOr<std::shared_ptr<Use>> use;
  {
    const std::lock_guard lock(mutex_);
    record = parts_.catalogue->GetVersion(map_name, version);
    if (!record.ok()) return record.status();
    use = UseVersion(*record);
    if (!use.ok()) return use.status();
  }
  Loaded& loaded = *(*use)->loaded;
  const absl::StatusOr<bool> was_in_memory = loaded.Load(*parts_.files);
  if (!was_in_memory.ok()) return was_in_memory.status();
  LoadedMap result{.record = *std::move(record),
                   .map = std::shared_ptr<const RadarMap>(*std::move(use), loaded.map.get()),
                   .was_in_memory = *was_in_memory};
  const std::lock_guard lock(mutex_);
  // Gone or relabelled meanwhile: what was loaded is still what was asked for.
  const absl::StatusOr<MapRecord> now = parts_.catalogue->GetMap(map_name);
  if (now.ok()) KeepWarm(*now, result);
  return result;
}

absl::StatusOr<LoadedMap> MapStore::AcquireFor(absl::string_view map_name,
                                               absl::string_view vehicle_id) {
  const absl::StatusOr<MapRecord> map = parts_.catalogue->GetMap(map_name);
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
  const absl::StatusOr<MapVersionRecord> record = Store(path, map_name, sha256, *map);
  if (!record.ok()) return record.status();
  const std::lock_guard lock(mutex_);
  std::weak_ptr<Loaded>& entry = loaded_[record->sha256];
  // The same file may be in memory already.
  if (!entry.expired()) return LoadedMap{.record = *record, .map = std::move(map)};
  const auto loaded = std::make_shared<Loaded>(record->sha256);
  loaded->map = std::move(map);
  entry = loaded;
  absl::StatusOr<std::shared_ptr<Use>> use = UseVersion(*record);
  if (!use.ok()) return use.status();
  return LoadedMap{.record = *record,
                   .map = std::shared_ptr<const RadarMap>(*std::move(use), loaded->map.get())};
}

absl::StatusOr<MapVersionRecord> MapStore::Store(const std::filesystem::path& path,
                                                 absl::string_view map_name,
                                                 absl::string_view sha256, const RadarMap& map) {
  const std::vector<CoverageBox> coverage = CoverageOf(map);
  const KeyedMutex::Lock file_lock = file_mutexes_.Take(std::string(sha256));
  absl::StatusOr<Hold> file_hold = parts_.catalogue->HoldFile(sha256, parts_.holder);
  if (!file_hold.ok()) return file_hold.status();
  // The file before its row: a row without a file would be a lie. And a note before the file, so
  // that one without a row is known to come from here.
  const absl::StatusOr<bool> known = parts_.catalogue->HasFile(sha256);
  absl::Status status = known.status();
  if (status.ok() && !*known) status = parts_.catalogue->AddLooseFile(sha256);
  if (status.ok()) status = parts_.files->Keep(path, sha256);
  if (!status.ok()) return status;
  const std::lock_guard change(change_mutex_);
  absl::StatusOr<MapVersionRecord> record =
      parts_.catalogue->AddVersion(map_name, sha256, map.info(), coverage);
  *file_hold = Hold();
  // After an internal error the row may be there once the catalogue is opened again.
  if (!record.ok() && !absl::IsInternal(record.status())) RemoveFile(sha256);
  return record;
}

absl::StatusOr<MapVersionRecord> MapStore::AddStored(absl::string_view prefix,
                                                     absl::string_view map_name,
                                                     absl::string_view sha256) {
  const absl::Status missing =
      absl::NotFoundError(absl::StrCat("header.sha256 is ", sha256, "; no map has that file"));
  const absl::StatusOr<std::int64_t> wanted = parts_.catalogue->SizeOfFile(prefix, sha256);
  if (!wanted.ok()) return wanted.status();
  if (*wanted == 0) return missing;
  const absl::StatusOr<std::shared_ptr<const RadarMap>> map = parts_.files->Open(sha256);
  if (absl::IsNotFound(map.status()) || absl::IsDataLoss(map.status())) return missing;
  if (!map.ok()) return map.status();
  const std::vector<CoverageBox> coverage = CoverageOf(**map);
  const KeyedMutex::Lock file_lock = file_mutexes_.Take(std::string(sha256));
  const std::lock_guard change(change_mutex_);
  const absl::StatusOr<Hold> file_hold = parts_.catalogue->HoldFile(sha256, parts_.holder);
  if (!file_hold.ok()) return file_hold.status();
  // Its version may have been deleted meanwhile.
  const absl::StatusOr<std::int64_t> size = parts_.catalogue->SizeOfFile(prefix, sha256);
  if (!size.ok()) return size.status();
  if (*size == 0) return missing;
  return parts_.catalogue->AddVersion(map_name, sha256, (*map)->info(), coverage);
}

absl::StatusOr<bool> MapStore::HasStored(absl::string_view prefix, absl::string_view sha256) {
  const absl::StatusOr<std::int64_t> wanted = parts_.catalogue->SizeOfFile(prefix, sha256);
  if (!wanted.ok()) return wanted.status();
  if (*wanted == 0) return false;
  const absl::Status status = parts_.files->Check(sha256, [](std::size_t) { return true; });
  if (absl::IsNotFound(status) || absl::IsDataLoss(status)) return false;
  if (!status.ok()) return status;
  return true;
}

absl::StatusOr<MapRecord> MapStore::Activate(absl::string_view map_name, std::int64_t version) {
  // Warm before any session can ask for it, and held until it is known to be the active one.
  const absl::StatusOr<LoadedMap> loaded = Acquire(map_name, version);
  if (!loaded.ok()) return loaded.status();
  const std::lock_guard change(change_mutex_);
  if (absl::Status status = parts_.catalogue->Activate(map_name, version); !status.ok())
    return status;
  return Relabelled(map_name, *loaded);
}

absl::StatusOr<MapRecord> MapStore::RollBack(absl::string_view map_name) {
  const absl::StatusOr<MapRecord> map = parts_.catalogue->GetMap(map_name);
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
  const std::lock_guard change(change_mutex_);
  absl::Status status = parts_.catalogue->SetCanary(map_name, version, share);
  if (!status.ok()) return status;
  return Relabelled(map_name, loaded);
}

absl::StatusOr<MapRecord> MapStore::Relabelled(absl::string_view map_name,
                                               const LoadedMap& loaded) {
  absl::StatusOr<MapRecord> map = parts_.catalogue->GetMap(map_name);
  const std::lock_guard lock(mutex_);
  if (map.ok()) KeepWarm(*map, loaded);
  return map;
}

absl::StatusOr<int> MapStore::RemoveStaleUploads(std::chrono::nanoseconds served) {
  return parts_.incoming->RemoveStale(served, options_.unfinished_upload_timeout);
}

absl::StatusOr<int> MapStore::RemoveExpiredQuarantine(std::chrono::nanoseconds served) {
  CountQuarantine();
  if (options_.quarantine_time.count() == 0) return 0;
  if (!sweeps_) {
    // Of the processes that share the files, one counts the time, as long as it lives.
    absl::StatusOr<Hold> hold = parts_.catalogue->HoldFile(kQuarantine, parts_.holder);
    if (absl::IsUnavailable(hold.status())) return 0;
    if (!hold.ok()) return hold.status();
    sweeps_ = *std::move(hold);
  }
  return parts_.files->RemoveExpiredQuarantine(served, options_.quarantine_time);
}

absl::StatusOr<int> MapStore::SetLooseFilesAside() {
  return server::SetLooseFilesAside(*parts_.catalogue, *parts_.files, parts_.holder);
}

void MapStore::CountQuarantine() {
  quarantined_count_ = parts_.files->QuarantinedCount().value_or(-1);
}

std::optional<int> MapStore::quarantined_count() const {
  const int count = quarantined_count_;
  return count < 0 ? std::nullopt : std::optional<int>(count);
}

absl::Status MapStore::DeleteVersion(absl::string_view map_name, std::int64_t version) {
  const std::lock_guard change(change_mutex_);
  const absl::StatusOr<MapVersionRecord> record = parts_.catalogue->GetVersion(map_name, version);
  if (!record.ok()) return record.status();
  absl::Status status = parts_.catalogue->DeleteVersion(map_name, version);
  if (status.ok()) RemoveFile(record->sha256);
  return status;
}

absl::Status MapStore::DeleteMap(absl::string_view map_name) {
  const std::lock_guard change(change_mutex_);
  const absl::StatusOr<std::vector<MapVersionRecord>> versions = parts_.catalogue->ListVersions(
      map_name, std::numeric_limits<std::int64_t>::max(), std::numeric_limits<int>::max());
  if (!versions.ok()) return versions.status();
  absl::Status status = parts_.catalogue->DeleteMap(map_name);
  if (!status.ok()) return status;
  for (const MapVersionRecord& record : *versions) RemoveFile(record.sha256);
  const std::lock_guard lock(mutex_);
  warm_.KeepOnly(map_name, 0, 0);
  return status;
}

void MapStore::RemoveFile(absl::string_view sha256) {
  const absl::Status status =
      RemoveOrphan(*parts_.catalogue, *parts_.files, sha256, parts_.holder).status();
  if (status.ok()) return;
  spdlog::warn("map file not removed sha256={} reason={}", std::string(sha256),
               Quoted(status.message()));
}

int MapStore::loaded_map_count() {
  const std::lock_guard lock(mutex_);
  int count = 0;
  for (const auto& [key, loaded] : loaded_) count += loaded.expired() ? 0 : 1;
  return count;
}

absl::StatusOr<std::shared_ptr<MapStore::Use>> MapStore::UseVersion(
    const MapVersionRecord& record) {
  const Key key(record.map_name, record.version);
  std::erase_if(uses_, [](const auto& entry) { return entry.second.expired(); });
  std::erase_if(loaded_, [](const auto& entry) { return entry.second.expired(); });
  if (const auto known = uses_.find(key); known != uses_.end()) {
    if (std::shared_ptr<Use> use = known->second.lock()) return use;
  }
  absl::StatusOr<Hold> hold =
      parts_.catalogue->HoldVersion(record.map_name, record.version, parts_.holder);
  if (!hold.ok()) return hold.status();
  std::weak_ptr<Loaded>& entry = loaded_[record.sha256];
  std::shared_ptr<Loaded> loaded = entry.lock();
  if (loaded == nullptr) entry = loaded = std::make_shared<Loaded>(record.sha256);
  auto use = std::make_shared<Use>(Use{.hold = *std::move(hold), .loaded = std::move(loaded)});
  uses_[key] = use;
  return use;
}

void MapStore::KeepWarm(const MapRecord& map, const LoadedMap& loaded) {
  const Key key(map.name, loaded.record.version);
  if (key.second != 0 && (key.second == map.active_version || key.second == map.canary_version)) {
    if (std::shared_ptr<Loaded> in_memory = loaded_[loaded.record.sha256].lock()) {
      warm_.Keep(key, std::move(in_memory),
                 static_cast<std::int64_t>(loaded.record.info.size_bytes));
    }
  }
  warm_.KeepOnly(map.name, map.active_version, map.canary_version);
}

}  // namespace dcloc::server
