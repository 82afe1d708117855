#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/maps/store/store_audit.h"

/// Backups of the embedded store. A backup is a folder that is laid out as a store is.
namespace dcloc::server {

struct BackupReport {
  std::int64_t file_count = 0;    ///< map files in the backup
  std::int64_t copied_count = 0;  ///< of them, copied now; the others were there
  std::int64_t size_bytes = 0;
  std::vector<std::string>
      damaged_files;  ///< hashes: damaged or missing where they were to come from
};

/// Copies catalogue, identities and map files into `backup`, also while a server works on the
/// store. In a folder that is a backup already only new files are copied, and those that no version
/// has any more are removed. It is the old backup until all is copied, and the new one from then
/// on, however it is stopped. Damaged files are left out. FailedPrecondition: `backup` is the store
/// of a server, or the store changes too fast; Cancelled when `watch` stops it.
absl::StatusOr<BackupReport> BackUpStore(const std::filesystem::path& folder,
                                         const std::filesystem::path& backup, StoreWatcher watch);

/// Puts a backup's maps in place of those of a store that no server has. All files are copied and
/// checked before anything is changed. What is not in the backup is not lost: the catalogue that
/// was there is kept beside the new one with ".aside-TIME" in its name, and map files go to
/// quarantine. Identities that are there stay, so that what was revoked stays so.
/// FailedPrecondition: a server has the folder; InvalidArgument: they are one folder; DataLoss: the
/// backup is damaged; Cancelled when `watch` stops it.
absl::StatusOr<BackupReport> RestoreStore(const std::filesystem::path& backup,
                                          const std::filesystem::path& folder, StoreWatcher watch);

/// Moves a database of a store aside, with what SQLite keeps beside it, if there is one: its name
/// then ends with ".aside-TIME".
absl::Status SetDatabaseAside(const std::filesystem::path& database);

}  // namespace dcloc::server
