#include "server/app/shared_storage.h"

#include <chrono>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/base/status.h"
#include "server/identity/postgres_identity_store.h"
#include "server/maps/catalogue/postgres_catalogue.h"
#include "server/maps/store/map_folder.h"
#include "server/postgres/postgres_database.h"
#include "server/postgres/postgres_error.h"

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

absl::StatusOr<MapStoreParts> OpenParts(const std::shared_ptr<PostgresDatabase>& database,
                                        const ServerConfig& config, const std::string& holder) {
  const std::filesystem::path shared(config.map_folder);
  auto files = MapFolder::Open(shared / "maps", shared / "quarantine", holder);
  if (!files.ok()) return WithPrefix("map_folder: ", WithPath(files.status()));
  auto catalogue = PostgresCatalogue::Open(database);
  if (!catalogue.ok()) return AtStart(catalogue.status());
  const StorePaths own = PathsOf(config.data);
  auto incoming = IncomingFiles::Open(own.incoming);
  if (!incoming.ok()) return WithPath(incoming.status());
  auto builds = BuildLedger::Open(own.builds);
  if (!builds.ok()) return WithPath(builds.status());
  return MapStoreParts{.catalogue = *std::move(catalogue),
                       .files = *std::move(files),
                       .incoming = *std::move(incoming),
                       .builds = *std::move(builds),
                       .holder = holder};
}

}  // namespace

absl::StatusOr<Storage> OpenSharedStorage(const ServerConfig& config,
                                          const MapStoreOptions& options,
                                          const std::string& holder) {
  absl::StatusOr<FileDescriptor> lock = LockStore(config.data);
  if (!lock.ok()) return lock.status();
  const auto database = OpenDatabase(config);
  if (!database.ok()) return database.status();
  absl::StatusOr<MapStoreParts> parts = OpenParts(*database, config, holder);
  if (!parts.ok()) return parts.status();
  auto identities = OpenIdentitiesIn(*database, config);
  if (!identities.ok()) return identities.status();
  absl::StatusOr<std::unique_ptr<MapStore>> maps = MapStore::Open(*std::move(parts), options);
  if (!maps.ok()) return WithPrefix("map_folder: ", WithPath(maps.status()));
  return Storage{
      .lock = *std::move(lock), .maps = *std::move(maps), .identities = *std::move(identities)};
}

absl::StatusOr<std::unique_ptr<IdentityStore>> OpenSharedIdentities(const ServerConfig& config) {
  const auto database = OpenDatabase(config);
  if (!database.ok()) return database.status();
  return OpenIdentitiesIn(*database, config);
}

}  // namespace dcloc::server
