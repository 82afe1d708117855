#include "server/app/shared_storage.h"

#include <chrono>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/base/status.h"
#include "server/identity/postgres_identity_store.h"
#include "server/maps/catalogue/postgres_build_queue.h"
#include "server/maps/catalogue/postgres_catalogue.h"
#include "server/maps/store/cached_map_files.h"
#include "server/maps/store/kept_files.h"
#include "server/maps/store/map_bucket.h"
#include "server/maps/store/map_folder.h"
#include "server/objects/object_error.h"
#include "server/passes/pass_key.h"
#include "server/passes/postgres_pass_rows.h"
#include "server/postgres/postgres_database.h"
#include "server/postgres/postgres_error.h"
#include "server/replicas/postgres_replica_directory.h"

namespace dcloc::server {
namespace {

/// For an operator, who may know where the database is and why it does not answer.
absl::Status AtStart(const absl::Status& status) {
  if (!IsAway(status)) return WithPrefix("catalogue: ", status);
  return absl::UnavailableError(
      absl::StrCat("catalogue: the database does not answer: ", AwayReason(status)));
}

absl::StatusOr<std::shared_ptr<PostgresDatabase>> OpenDatabase(const ServerConfig& config) {
  auto database = PostgresDatabase::Open(DatabaseOptionsOf(config));
  if (!database.ok()) return AtStart(database.status());
  return database;
}

absl::StatusOr<std::unique_ptr<IdentityStore>> OpenIdentitiesIn(
    const std::shared_ptr<PostgresDatabase>& database, const ServerConfig& config) {
  auto identities =
      PostgresIdentityStore::Open(database, std::chrono::seconds(config.identity_away_s));
  if (!identities.ok()) return AtStart(identities.status());
  return identities;
}

/// The files that all servers share, and what of them is counted.
struct SharedFiles {
  std::unique_ptr<MapFiles> files;
  std::shared_ptr<ObjectStore> objects;
  std::shared_ptr<const MapCache> cache;
};

/// InvalidArgument when the service answers and refuses this server, so that waiting does not help:
/// no such bucket, a key or a certificate that is not good. OK while it is away: what is in the
/// cache can be served.
absl::Status CheckAtTheDoor(ObjectStore& objects) {
  const absl::Status status = objects.List("quarantine").status();
  if (status.ok() || objects.away()) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("map_files is ", objects.options().location,
                                                 " at ", objects.options().endpoint, ": ",
                                                 ObjectStoreReason(status)));
}

absl::StatusOr<SharedFiles> OpenFarFiles(const ServerConfig& config, const std::string& holder) {
  if (!config.map_files.empty()) {
    absl::StatusOr<std::shared_ptr<ObjectStore>> objects =
        ObjectStore::Open(ObjectOptionsOf(config));
    if (!objects.ok()) return objects.status();
    if (absl::Status status = CheckAtTheDoor(**objects); !status.ok()) return status;
    return SharedFiles{
        .files = std::make_unique<MapBucket>(*objects), .objects = *objects, .cache = nullptr};
  }
  const std::filesystem::path shared(config.map_folder);
  auto files = MapFolder::Open(shared / "maps", shared / "quarantine", holder);
  if (!files.ok()) return WithPrefix("map_folder: ", WithPath(files.status()));
  return SharedFiles{.files = *std::move(files), .objects = nullptr, .cache = nullptr};
}

absl::StatusOr<SharedFiles> OpenFiles(const ServerConfig& config, const std::string& holder) {
  absl::StatusOr<SharedFiles> far = OpenFarFiles(config, holder);
  if (!far.ok() || config.map_cache_mib == 0) return far;
  const std::filesystem::path folder = config.map_cache.empty()
                                           ? PathsOf(config.data).cache
                                           : std::filesystem::path(config.map_cache);
  absl::StatusOr<std::shared_ptr<MapCache>> cache =
      MapCache::Open(folder, std::int64_t{config.map_cache_mib} << 20);
  if (!cache.ok()) return WithPrefix("map_cache: ", WithPath(cache.status()));
  far->files = std::make_unique<CachedMapFiles>(std::move(far->files), *cache);
  far->cache = *std::move(cache);
  return far;
}

/// The setting in front, and for an operator why an object store refuses this server.
absl::Status AtStart(const SharedFiles& files, const absl::Status& status) {
  if (files.objects == nullptr) return WithPrefix("map_folder: ", WithPath(status));
  if (!IsObjectStoreError(status)) return WithPrefix("map_files: ", status);
  return absl::UnavailableError(absl::StrCat("map_files: ", ObjectStoreReason(status)));
}

/// A folder that is not there, and is missed, has not been mounted or is another one: made anew it
/// would say that all maps are damaged.
absl::Status CheckFolderIsThere(const ServerConfig& config, Catalogue& catalogue) {
  if (!config.map_files.empty()) return absl::OkStatus();
  std::error_code error;
  if (std::filesystem::exists(std::filesystem::path(config.map_folder) / "maps", error)) {
    return absl::OkStatus();
  }
  const auto wanted = catalogue.ListFiles();
  if (!wanted.ok()) return AtStart(wanted.status());
  if (wanted->empty()) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat(
      "map_folder: ", config.map_folder, " has no folder \"maps\", and the catalogue has ",
      wanted->size(), " map files: mount it, or name the folder that they are in"));
}

/// Files of one kind beside the map files, where all servers find them.
absl::StatusOr<std::unique_ptr<KeptFiles>> OpenKept(const ServerConfig& config,
                                                    const SharedFiles& files, const char* kind) {
  if (files.objects != nullptr) {
    return std::make_unique<KeptObjects>(files.objects, absl::StrCat(kind, "/"));
  }
  auto kept = KeptFolder::Open(std::filesystem::path(config.map_folder) / kind);
  if (!kept.ok()) return WithPrefix("map_folder: ", WithPath(kept.status()));
  return kept;
}

/// Without a key that all servers have, vehicles cannot be told apart: then nothing is kept.
absl::StatusOr<std::unique_ptr<PassStore>> OpenPasses(
    const std::shared_ptr<PostgresDatabase>& database, const ServerConfig& config,
    const SharedFiles& files) {
  absl::StatusOr<std::string> key =
      config.pass_key.empty() ? std::string() : ReadPassKey(config.pass_key);
  if (!key.ok()) return key.status();
  auto rows = PostgresPassRows::Open(database);
  if (!rows.ok()) return AtStart(rows.status());
  auto kept = OpenKept(config, files, "passes");
  if (!kept.ok()) return kept.status();
  return std::make_unique<PassStore>(*std::move(rows), *std::move(kept), *std::move(key));
}

absl::StatusOr<MapStoreParts> OpenParts(const std::shared_ptr<PostgresDatabase>& database,
                                        std::unique_ptr<Catalogue> catalogue,
                                        const ServerConfig& config, const std::string& holder,
                                        SharedFiles& files) {
  const StorePaths own = PathsOf(config.data);
  auto incoming = IncomingFiles::Open(own.incoming);
  if (!incoming.ok()) return WithPath(incoming.status());
  auto builds = PostgresBuildQueue::Open(database);
  if (!builds.ok()) return AtStart(builds.status());
  auto inputs = OpenKept(config, files, "builds");
  if (!inputs.ok()) return inputs.status();
  return MapStoreParts{.catalogue = std::move(catalogue),
                       .files = std::move(files.files),
                       .incoming = *std::move(incoming),
                       .builds = *std::move(builds),
                       .build_inputs = *std::move(inputs),
                       .holder = holder};
}

}  // namespace

absl::StatusOr<Storage> OpenSharedStorage(const ServerConfig& config,
                                          const MapStoreOptions& options,
                                          const std::string& holder) {
  absl::StatusOr<StoreLock> lock = LockStore(config.data);
  if (!lock.ok()) return lock.status();
  const auto database = OpenDatabase(config);
  if (!database.ok()) return database.status();
  auto catalogue = PostgresCatalogue::Open(*database);
  if (!catalogue.ok()) return AtStart(catalogue.status());
  if (absl::Status status = CheckFolderIsThere(config, **catalogue); !status.ok()) return status;
  absl::StatusOr<SharedFiles> files = OpenFiles(config, holder);
  if (!files.ok()) return files.status();
  auto passes = OpenPasses(*database, config, *files);
  if (!passes.ok()) return passes.status();
  absl::StatusOr<MapStoreParts> parts =
      OpenParts(*database, *std::move(catalogue), config, holder, *files);
  if (!parts.ok()) return parts.status();
  auto identities = OpenIdentitiesIn(*database, config);
  if (!identities.ok()) return identities.status();
  auto replicas = PostgresReplicaDirectory::Open(*database);
  if (!replicas.ok()) return AtStart(replicas.status());
  absl::StatusOr<std::unique_ptr<MapStore>> maps = MapStore::Open(*std::move(parts), options);
  if (!maps.ok()) return AtStart(*files, maps.status());
  return Storage{.lock = *std::move(lock),
                 .maps = *std::move(maps),
                 .identities = *std::move(identities),
                 .passes = *std::move(passes),
                 .replicas = *std::move(replicas),
                 .objects = std::move(files->objects),
                 .cache = std::move(files->cache)};
}

absl::StatusOr<std::unique_ptr<IdentityStore>> OpenSharedIdentities(const ServerConfig& config) {
  const auto database = OpenDatabase(config);
  if (!database.ok()) return database.status();
  return OpenIdentitiesIn(*database, config);
}

}  // namespace dcloc::server
