#include "server/app/storage.h"

#include <unistd.h>

#include <array>
#include <chrono>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/identity/sqlite_identity_store.h"
#include "server/maps/catalogue/sqlite_catalogue.h"
#include "server/maps/store/map_folder.h"

namespace dcloc::server {
namespace {

/// "host:pid:when"; the time tells it from an earlier process, as containers use numbers again.
std::string NameOfThisProcess() {
  std::array<char, 256> host{};
  if (gethostname(host.data(), host.size() - 1) != 0) host = {"localhost"};
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return absl::StrCat(host.data(), ":", getpid(), ":",
                      std::chrono::duration_cast<std::chrono::milliseconds>(now).count());
}

absl::StatusOr<MapStoreParts> OpenMapParts(const std::filesystem::path& folder) {
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
  return MapStoreParts{.catalogue = *std::move(catalogue),
                       .files = *std::move(files),
                       .incoming = *std::move(incoming),
                       .builds = *std::move(builds),
                       .holder = NameOfThisProcess()};
}

}  // namespace

absl::StatusOr<Storage> OpenStorage(const std::filesystem::path& folder,
                                    const MapStoreOptions& options) {
  if (absl::Status status = CreateFolders(folder); !status.ok()) return status;
  absl::StatusOr<FileDescriptor> lock = LockFile(folder / "lock");
  if (!lock.ok()) return lock.status();
  absl::StatusOr<MapStoreParts> parts = OpenMapParts(folder);
  if (!parts.ok()) return parts.status();
  absl::StatusOr<std::unique_ptr<MapStore>> maps = MapStore::Open(*std::move(parts), options);
  if (!maps.ok()) return maps.status();
  absl::StatusOr<std::unique_ptr<IdentityStore>> identities = OpenIdentities(folder);
  if (!identities.ok()) return identities.status();
  return Storage{
      .lock = *std::move(lock), .maps = *std::move(maps), .identities = *std::move(identities)};
}

absl::StatusOr<std::unique_ptr<IdentityStore>> OpenIdentities(const std::filesystem::path& folder) {
  if (absl::Status status = CreateFolders(folder); !status.ok()) return status;
  return SqliteIdentityStore::Open(folder / "identities.sqlite");
}

}  // namespace dcloc::server
