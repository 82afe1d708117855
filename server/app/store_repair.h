#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/maps/store/store_audit.h"

namespace dcloc::server {

struct RepairOptions {
  bool adopt = false;  ///< files without a version become maps instead of going to quarantine
};

struct RepairReport {
  bool catalogue_replaced = false;     ///< by a new one; an old one is kept beside it
  std::vector<std::string> set_aside;  ///< other databases that were none, kept beside
  std::int64_t adopted_count = 0;
  std::int64_t quarantined_count = 0;
  StoreAudit audit;  ///< of the store as it is now
};

/// Brings a store that no server has into a state in which one starts, and loses nothing: a
/// catalogue that is no catalogue is moved aside, as are builds and passes whose database is none,
/// and map files that no version has are set aside or become maps named "recovered-HASH" with one
/// version, not active. NotFound: there is no store; FailedPrecondition: a server has the folder,
/// or a newer program wrote the catalogue; Cancelled when `watch` stops it.
absl::StatusOr<RepairReport> RepairStore(const std::filesystem::path& folder,
                                         const RepairOptions& options, StoreWatcher watch);

}  // namespace dcloc::server
