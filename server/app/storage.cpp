#include "server/app/storage.h"

#include <unistd.h>

#include <array>
#include <chrono>
#include <string>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/app/identity_mark.h"
#include "server/app/shared_storage.h"
#include "server/identity/sqlite_identity_store.h"
#include "server/maps/catalogue/sqlite_build_queue.h"
#include "server/maps/catalogue/sqlite_catalogue.h"
#include "server/maps/store/kept_files.h"
#include "server/maps/store/map_folder.h"
#include "server/passes/pass_key.h"
#include "server/passes/sqlite_pass_rows.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

std::string NameOfThisHost() {
  std::array<char, 256> host{};
  return gethostname(host.data(), host.size() - 1) == 0 ? host.data() : "localhost";
}

/// "host:pid:when"; the time tells it from an earlier process, as containers use numbers again.
std::string NameOfThisProcess() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return absl::StrCat(NameOfThisHost(), ":", getpid(), ":",
                      std::chrono::duration_cast<std::chrono::milliseconds>(now).count());
}

/// The store is its owner's alone, also one that an earlier program made. A folder of another owner
/// (a mounted volume) keeps its mode.
void MakePrivate(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  std::error_code error;
  fs::permissions(folder, fs::perms::owner_all, error);
  if (error) spdlog::warn("mode of the store's folder not changed reason={}", error.message());
  for (const char* file :
       {"catalogue.sqlite", "identities.sqlite", "jobs.sqlite", "passes.sqlite"}) {
    for (const char* part : {"", "-wal", "-shm"}) {
      fs::permissions(folder / absl::StrCat(file, part),
                      fs::perms::owner_read | fs::perms::owner_write, error);
    }
  }
}

/// A new catalogue is made only where there are no map files: beside some, it would know of none.
absl::Status CheckCatalogueIsThere(const std::filesystem::path& path, MapFiles& files) {
  const absl::StatusOr<std::int64_t> size = FileSize(path);
  if (!size.ok()) return size.status();
  const absl::StatusOr<std::vector<std::string>> present = files.List();
  if (!present.ok()) return present.status();
  if (*size > 0 || present->empty()) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrFormat(
      "the catalogue is missing or empty, and %d map files are there", present->size()));
}

/// What an operator can do about a store that cannot be opened.
absl::Status WithAdvice(const absl::Status& status, const std::filesystem::path& folder) {
  absl::Status told = WithPath(status);
  if (!absl::IsFailedPrecondition(status) && !absl::IsDataLoss(status)) return told;
  return absl::Status(
      status.code(),
      absl::StrFormat(
          "%s: %s. Nothing was changed. Put a backup in place with \"dcloc-server store restore "
          "--data %s --from BACKUP\", or set aside what is unknown with \"dcloc-server store "
          "repair "
          "--data %s\"",
          folder.string(), told.message(), folder.string(), folder.string()));
}

}  // namespace

StorePaths PathsOf(const std::filesystem::path& folder) {
  return {.catalogue = folder / "catalogue.sqlite",
          .identities = folder / "identities.sqlite",
          .jobs = folder / "jobs.sqlite",
          .passes = folder / "passes.sqlite",
          .maps = folder / "maps",
          .quarantine = folder / "quarantine",
          .incoming = folder / "incoming",
          .builds = folder / "builds",
          .pass_files = folder / "passes",
          .pass_key = folder / "pass.key",
          .cache = folder / "cache",
          .lock = folder / "lock"};
}

absl::StatusOr<MapStoreParts> OpenMapParts(const std::filesystem::path& folder) {
  const StorePaths paths = PathsOf(folder);
  absl::StatusOr<std::unique_ptr<MapFolder>> files = MapFolder::Open(paths.maps, paths.quarantine);
  if (!files.ok()) return files.status();
  absl::Status status = CheckCatalogueIsThere(paths.catalogue, **files);
  if (!status.ok()) return WithAdvice(status, folder);
  absl::StatusOr<std::unique_ptr<SqliteCatalogue>> catalogue =
      SqliteCatalogue::Open(paths.catalogue);
  if (!catalogue.ok()) return WithAdvice(catalogue.status(), folder);
  absl::StatusOr<std::unique_ptr<IncomingFiles>> incoming = IncomingFiles::Open(paths.incoming);
  if (!incoming.ok()) return incoming.status();
  absl::StatusOr<std::unique_ptr<SqliteBuildQueue>> builds = SqliteBuildQueue::Open(paths.jobs);
  if (!builds.ok()) return WithAdvice(builds.status(), folder);
  absl::StatusOr<std::unique_ptr<KeptFolder>> inputs = KeptFolder::Open(paths.builds);
  if (!inputs.ok()) return inputs.status();
  return MapStoreParts{.catalogue = *std::move(catalogue),
                       .files = *std::move(files),
                       .incoming = *std::move(incoming),
                       .builds = *std::move(builds),
                       .build_inputs = *std::move(inputs),
                       .holder = NameOfThisProcess()};
}

absl::StatusOr<StoreLock> LockStore(const std::filesystem::path& folder) {
  if (absl::Status status = CreateFolders(folder); !status.ok()) return WithPath(status);
  absl::StatusOr<StoreLock> lock = StoreLock::Take(PathsOf(folder).lock, NameOfThisHost());
  if (!lock.ok()) return WithPath(lock.status());
  return lock;
}

namespace {

absl::StatusOr<std::unique_ptr<PassStore>> OpenPasses(const StorePaths& paths,
                                                      const std::string& pass_key) {
  absl::StatusOr<std::string> key =
      pass_key.empty() ? ReadOrMakePassKey(paths.pass_key) : ReadPassKey(pass_key);
  if (!key.ok()) return key.status();
  absl::StatusOr<std::unique_ptr<SqlitePassRows>> rows = SqlitePassRows::Open(paths.passes);
  if (!rows.ok()) return rows.status();
  absl::StatusOr<std::unique_ptr<KeptFolder>> files = KeptFolder::Open(paths.pass_files);
  if (!files.ok()) return files.status();
  return std::make_unique<PassStore>(*std::move(rows), *std::move(files), *std::move(key));
}

}  // namespace

absl::StatusOr<Storage> OpenStorage(const std::filesystem::path& folder,
                                    const MapStoreOptions& options, const std::string& pass_key) {
  absl::StatusOr<StoreLock> lock = LockStore(folder);
  if (!lock.ok()) return lock.status();
  MakePrivate(folder);
  absl::StatusOr<MapStoreParts> parts = OpenMapParts(folder);
  if (!parts.ok()) return WithPath(parts.status());
  absl::StatusOr<std::unique_ptr<IdentityStore>> identities = OpenIdentities(folder);
  if (!identities.ok()) return identities.status();
  const absl::StatusOr<bool> any = (*identities)->HasAny();
  absl::Status status = any.status();
  if (any.ok()) status = *any ? SetIdentityMark(folder) : CheckNoIdentityIsLost(folder);
  if (!status.ok()) return WithPath(status);
  auto passes = OpenPasses(PathsOf(folder), pass_key);
  if (!passes.ok()) return WithAdvice(passes.status(), folder);
  absl::StatusOr<std::unique_ptr<MapStore>> maps = MapStore::Open(*std::move(parts), options);
  if (!maps.ok()) return WithAdvice(maps.status(), folder);
  return Storage{.lock = *std::move(lock),
                 .maps = *std::move(maps),
                 .identities = *std::move(identities),
                 .passes = *std::move(passes),
                 .replicas = nullptr,
                 .objects = nullptr,
                 .cache = nullptr};
}

absl::StatusOr<std::unique_ptr<IdentityStore>> OpenIdentities(const std::filesystem::path& folder) {
  if (absl::Status status = CreateFolders(folder); !status.ok()) return WithPath(status);
  auto identities = SqliteIdentityStore::Open(PathsOf(folder).identities);
  if (absl::IsDataLoss(identities.status())) {
    return absl::DataLossError(
        absl::StrCat(WithPath(identities.status()).message(),
                     ". Put a backup's identities.sqlite in place, or move this one aside and make "
                     "new ones with \"dcloc-server token create\""));
  }
  if (!identities.ok()) return WithPath(identities.status());
  return identities;
}

absl::StatusOr<Storage> OpenStorage(const ServerConfig& config, const MapStoreOptions& options) {
  if (config.catalogue.empty()) {
    return OpenStorage(std::filesystem::path(config.data), options, config.pass_key);
  }
  return OpenSharedStorage(config, options, NameOfThisProcess());
}

absl::StatusOr<std::unique_ptr<IdentityStore>> OpenIdentities(const ServerConfig& config) {
  if (config.catalogue.empty()) return OpenIdentities(std::filesystem::path(config.data));
  return OpenSharedIdentities(config);
}

}  // namespace dcloc::server
