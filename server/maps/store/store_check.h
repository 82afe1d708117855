#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/base/clock.h"
#include "server/maps/catalogue/catalogue.h"
#include "server/maps/store/incoming_files.h"
#include "server/maps/store/map_files.h"

namespace dcloc::server {

/// What the check of a store found when it was opened, and what it repaired.
struct StoreReport {
  int removed_leftover_count = 0;   ///< files in `incoming` that belong to nothing
  int removed_map_file_count = 0;   ///< map files that no version has, nor anyone holds
  int stale_upload_count = 0;       ///< unfinished uploads that were too old: removed
  int unfinished_upload_count = 0;  ///< kept, can be continued
  int covered_version_count = 0;    ///< versions to which coverage was added
  /// Hashes of files that versions have but that are missing or have a wrong size. The versions
  /// stay but cannot be loaded; uploading the same file again repairs them.
  std::vector<std::string> broken_files;
};

/// Compares files and catalogue, and repairs what a crash can leave behind. Other processes may use
/// catalogue and files meanwhile: a file that no version has is left alone while anyone holds it
/// (`RemoveOrphan`). `incoming` is this process's own. `stale_before`: unfinished uploads not
/// written to since then are removed. `holder`: as in the catalogue's holds.
absl::StatusOr<StoreReport> CheckStore(Catalogue& catalogue, MapFiles& files,
                                       IncomingFiles& incoming, SystemTime stale_before,
                                       absl::string_view holder);

/// A line for each thing that was done or is wrong; none when all is well.
void Log(const StoreReport& report);

}  // namespace dcloc::server
