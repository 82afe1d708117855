#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/maps/catalogue/catalogue.h"
#include "server/maps/store/incoming_files.h"
#include "server/maps/store/map_files.h"

namespace dcloc::server {

/// What the check of a store found when it was opened, and what it repaired.
struct StoreReport {
  int removed_leftover_count = 0;   ///< files in `incoming` that belong to nothing
  int quarantined_file_count = 0;   ///< map files that a crash left without a version: set aside
  int stale_upload_count = 0;       ///< unfinished uploads that were too old: removed
  int unfinished_upload_count = 0;  ///< kept, can be continued
  int covered_version_count = 0;    ///< versions to which coverage was added
  bool files_away = false;          ///< the storage of files was away: they were not checked
  /// Hashes of files that versions have but that are missing or have a wrong size. The versions
  /// stay but cannot be loaded; uploading the same file again repairs them.
  std::vector<std::string> broken_files;
};

/// Map files for which the catalogue cannot account: no version has them, and it does not know that
/// they were being stored or removed (Catalogue::AddLooseFile). Then the catalogue is not the one
/// of these files, or not the newest one.
absl::StatusOr<std::vector<std::string>> UnaccountedFiles(Catalogue& catalogue, MapFiles& files);

/// Sets aside map files that were being stored or removed when a process died, and gives their
/// number. What anyone holds is left alone: of a process that shares the files, until its lease is
/// over. So this is to be called again, and not at a start alone.
absl::StatusOr<int> SetLooseFilesAside(Catalogue& catalogue, MapFiles& files,
                                       absl::string_view holder);

/// Compares files and catalogue, and repairs what a crash can leave behind: files that were being
/// stored or removed are set aside. FailedPrecondition, and nothing is changed, when there are
/// files for which the catalogue cannot account. Other processes may use catalogue and files
/// meanwhile: a file that no version has is left alone while anyone holds it (`QuarantineOrphan`).
/// While the storage of files is away they are not checked: what is loaded is verified anyway.
/// `incoming` is this process's own. `stale_age`: unfinished uploads that have been there for so
/// long are removed. `holder`: as in the catalogue's holds.
absl::StatusOr<StoreReport> CheckStore(Catalogue& catalogue, MapFiles& files,
                                       IncomingFiles& incoming, std::chrono::nanoseconds stale_age,
                                       absl::string_view holder);

/// A line for each thing that was done or is wrong; none when all is well.
void Log(const StoreReport& report);

}  // namespace dcloc::server
