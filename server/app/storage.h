#pragma once

#include <filesystem>
#include <memory>

#include "absl/status/statusor.h"
#include "server/base/files.h"
#include "server/identity/identity_store.h"
#include "server/maps/store/map_store.h"

namespace dcloc::server {

/// A server's persistent storage. `OpenStorage` and `OpenIdentities` are the only functions that
/// choose the implementations of Catalogue, MapFiles and IdentityStore. A second implementation
/// goes beside its interface (`maps/catalogue/`, `maps/store/`, `identity/`) and is chosen in these
/// functions, by the form of the location.
struct Storage {
  FileDescriptor lock;  ///< of the folder; released last
  std::unique_ptr<MapStore> maps;
  std::unique_ptr<IdentityStore> identities;
};

/// Opens or creates the storage in `folder`: SQLite files and map files, for one process.
/// FailedPrecondition when another one has it open.
absl::StatusOr<Storage> OpenStorage(const std::filesystem::path& folder,
                                    const MapStoreOptions& options = {});

/// Opens or creates the identities alone, beside a server that runs on `folder` or without one.
absl::StatusOr<std::unique_ptr<IdentityStore>> OpenIdentities(const std::filesystem::path& folder);

}  // namespace dcloc::server
