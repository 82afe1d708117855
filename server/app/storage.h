#pragma once

#include <filesystem>
#include <memory>

#include "absl/status/statusor.h"
#include "server/app/store_lock.h"
#include "server/config/config.h"
#include "server/identity/identity_store.h"
#include "server/maps/store/map_cache.h"
#include "server/maps/store/map_store.h"
#include "server/objects/object_store.h"
#include "server/passes/pass_store.h"
#include "server/replicas/replica_directory.h"

namespace dcloc::server {

/// A server's persistent storage. `OpenStorage` and `OpenIdentities` choose the implementations of
/// Catalogue, MapFiles and IdentityStore that a server and `dcloc-server token` use: the embedded
/// ones in a folder, or with `ServerConfig::catalogue` those that several servers share
/// (`app/shared_storage`). Tools of the embedded store (`store_*`, `identity_mark`) name its own.
struct Storage {
  StoreLock lock;  ///< of the folder; released last
  std::unique_ptr<MapStore> maps;
  std::unique_ptr<IdentityStore> identities;
  std::unique_ptr<PassStore> passes;
  std::unique_ptr<ReplicaDirectory> replicas;  ///< null: this server is by itself
  std::shared_ptr<const ObjectStore> objects;  ///< null: map files are in a folder
  std::shared_ptr<const MapCache> cache;       ///< null: there is none
};

/// Where the parts of the embedded store are.
struct StorePaths {
  std::filesystem::path catalogue, identities, jobs, passes;  ///< SQLite files
  std::filesystem::path maps, quarantine, incoming, builds;   ///< folders
  std::filesystem::path pass_files;                           ///< a folder
  std::filesystem::path pass_key;                             ///< of pseudonyms
  std::filesystem::path cache;                                ///< of files that servers share
  std::filesystem::path lock;                                 ///< of the process that serves it
};
StorePaths PathsOf(const std::filesystem::path& folder);

/// Holds the folder, which is made if it is not there. FailedPrecondition when another process has
/// it, on another host too.
absl::StatusOr<StoreLock> LockStore(const std::filesystem::path& folder);

/// Opens or creates the parts of the embedded store's maps. FailedPrecondition when the catalogue
/// is missing beside map files, is a newer program's or something else; DataLoss when it is no
/// database. Then nothing is changed.
absl::StatusOr<MapStoreParts> OpenMapParts(const std::filesystem::path& folder);

/// Opens or creates the storage in `folder`: SQLite files and map files, for one process, readable
/// by their owner alone. Errors of `LockStore`, `OpenMapParts` and `MapStore::Open`, and
/// FailedPrecondition when identities that there were are lost; with the folder and what mends it.
/// `pass_key` is the setting of that name.
absl::StatusOr<Storage> OpenStorage(const std::filesystem::path& folder,
                                    const MapStoreOptions& options = {},
                                    const std::string& pass_key = "");

/// The storage that `config` names: the embedded one in `data`, or the shared one.
absl::StatusOr<Storage> OpenStorage(const ServerConfig& config, const MapStoreOptions& options);

/// Opens or creates the identities alone, beside a server that runs on `folder` or without one.
absl::StatusOr<std::unique_ptr<IdentityStore>> OpenIdentities(const std::filesystem::path& folder);

/// Those that `config` names.
absl::StatusOr<std::unique_ptr<IdentityStore>> OpenIdentities(const ServerConfig& config);

}  // namespace dcloc::server
