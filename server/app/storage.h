#pragma once

#include <filesystem>
#include <memory>

#include "absl/status/statusor.h"
#include "server/base/files.h"
#include "server/identity/identity_store.h"
#include "server/maps/store/map_store.h"

namespace dcloc::server {

/// A server's persistent storage. `OpenMapParts` and `OpenIdentities` are the only functions that
/// choose the implementations of Catalogue, MapFiles and IdentityStore. A second implementation
/// goes beside its interface (`maps/catalogue/`, `maps/store/`, `identity/`) and is chosen in these
/// functions, by the form of the location.
struct Storage {
  FileDescriptor lock;  ///< of the folder; released last
  std::unique_ptr<MapStore> maps;
  std::unique_ptr<IdentityStore> identities;
};

/// Where the parts of the embedded store are.
struct StorePaths {
  std::filesystem::path catalogue, identities;               ///< SQLite files
  std::filesystem::path maps, quarantine, incoming, builds;  ///< folders
  std::filesystem::path lock;                                ///< of the process that serves it
};
StorePaths PathsOf(const std::filesystem::path& folder);

/// Holds the folder, which is made if it is not there. FailedPrecondition when another process has
/// it.
absl::StatusOr<FileDescriptor> LockStore(const std::filesystem::path& folder);

/// Opens or creates the parts of the embedded store's maps. FailedPrecondition when the catalogue
/// is missing beside map files, is a newer program's or something else; DataLoss when it is no
/// database. Then nothing is changed.
absl::StatusOr<MapStoreParts> OpenMapParts(const std::filesystem::path& folder);

/// Opens or creates the storage in `folder`: SQLite files and map files, for one process, readable
/// by their owner alone. Errors of `LockStore`, `OpenMapParts` and `MapStore::Open`, and
/// FailedPrecondition when identities that there were are lost; with the folder and what mends it.
absl::StatusOr<Storage> OpenStorage(const std::filesystem::path& folder,
                                    const MapStoreOptions& options = {});

/// Opens or creates the identities alone, beside a server that runs on `folder` or without one.
absl::StatusOr<std::unique_ptr<IdentityStore>> OpenIdentities(const std::filesystem::path& folder);

}  // namespace dcloc::server
