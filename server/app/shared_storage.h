#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "server/app/storage.h"
#include "server/config/config.h"

namespace dcloc::server {

/// The storage that several servers share: catalogue and identities in `config.catalogue`, a
/// PostgreSQL database, and map files in `config.map_folder` or `config.map_files`, an object
/// store, read through a cache on this host. What is this server's own (unfinished uploads, builds,
/// and the lock that makes it so) is in `config.data`. `holder` names this process. Errors name the
/// setting and, for the log, why the database is away.
absl::StatusOr<Storage> OpenSharedStorage(const ServerConfig& config,
                                          const MapStoreOptions& options,
                                          const std::string& holder);

/// The identities alone, beside servers that run or without one.
absl::StatusOr<std::unique_ptr<IdentityStore>> OpenSharedIdentities(const ServerConfig& config);

}  // namespace dcloc::server
