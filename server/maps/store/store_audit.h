#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/statusor.h"
#include "server/maps/catalogue/catalogue.h"
#include "server/maps/store/map_files.h"

namespace dcloc::server {

/// How far a long work on map files is.
struct StoreProgress {
  std::int64_t done_bytes = 0;
  std::int64_t size_bytes = 0;  ///< in all
};

/// Called with the progress again and again; false stops the work.
using StoreWatcher = absl::FunctionRef<bool(const StoreProgress&)>;

/// What a store has, and what is wrong with it.
struct StoreAudit {
  std::int64_t file_count = 0;  ///< that versions have
  std::int64_t size_bytes = 0;
  std::vector<std::string> missing_files;
  std::vector<std::string> damaged_files;
  std::vector<std::string> unaccounted_files;  ///< `UnaccountedFiles`
  std::int64_t quarantined_count = 0;

  bool ok() const {
    return missing_files.empty() && damaged_files.empty() && unaccounted_files.empty();
  }
};

/// Reads every map file that a version has against its hash; changes nothing. A server may work on
/// the store meanwhile. Cancelled when `watch` stops it.
absl::StatusOr<StoreAudit> AuditStore(Catalogue& catalogue, MapFiles& files, StoreWatcher watch);

}  // namespace dcloc::server
