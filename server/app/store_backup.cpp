#include "server/app/store_backup.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/app/identity_mark.h"
#include "server/app/storage.h"
#include "server/base/files.h"
#include "server/base/sqlite_copy.h"
#include "server/maps/catalogue/sqlite_catalogue.h"
#include "server/maps/store/copy_map_file.h"
#include "server/maps/store/map_folder.h"

namespace dcloc::server {
namespace {

namespace fs = std::filesystem;

using Files = std::vector<std::pair<std::string, std::int64_t>>;  ///< hash and size of each

absl::StatusOr<Files> FilesOf(const fs::path& catalogue_path) {
  if (absl::Status status = CheckDatabase(catalogue_path); !status.ok()) return status;
  const auto catalogue = SqliteCatalogue::OpenToRead(catalogue_path);
  if (!catalogue.ok()) return catalogue.status();
  return (*catalogue)->ListFiles();
}

/// Copies files from one folder of maps to another place.
class FileCopier {
 public:
  FileCopier(const fs::path& from, StoreWatcher watch) : from_(from), watch_(watch) {}

  void SetSize(std::int64_t size_bytes) { progress_.size_bytes = size_bytes; }

  /// `target` is the file's new place.
  absl::Status Copy(const std::string& sha256, const fs::path& target) {
    if (absl::Status status = CreateFolders(target.parent_path()); !status.ok()) return status;
    return CopyMapFile(MapFolder::PathIn(from_, sha256), target, sha256,
                       [this](std::size_t piece_bytes) {
                         return Advance(static_cast<std::int64_t>(piece_bytes));
                       });
  }

  bool Advance(std::int64_t bytes) {
    progress_.done_bytes += bytes;
    return watch_(progress_);
  }

 private:
  const fs::path from_;
  StoreWatcher watch_;
  StoreProgress progress_;
};

std::int64_t TotalSize(const Files& files) {
  std::int64_t sum_bytes = 0;
  for (const auto& [sha256, size_bytes] : files) sum_bytes += size_bytes;
  return sum_bytes;
}

bool Has(const Files& files, const std::string& sha256) {
  return std::ranges::find(files, sha256, &Files::value_type::first) != files.end();
}

/// Copies what is not in the backup yet.
absl::StatusOr<BackupReport> CopyNewFiles(const Files& files, const fs::path& maps,
                                          const fs::path& backup_maps, StoreWatcher watch) {
  BackupReport report{.file_count = static_cast<std::int64_t>(files.size()),
                      .size_bytes = TotalSize(files)};
  FileCopier copier(maps, watch);
  copier.SetSize(report.size_bytes);
  for (const auto& [sha256, size_bytes] : files) {
    const fs::path target = MapFolder::PathIn(backup_maps, sha256);
    const absl::StatusOr<std::int64_t> there = FileSize(target);
    if (!there.ok()) return there.status();
    if (*there == size_bytes) {
      if (!copier.Advance(size_bytes)) return absl::CancelledError("stopped");
      continue;
    }
    const absl::Status status = copier.Copy(sha256, target);
    if (status.ok()) {
      ++report.copied_count;
    } else if (absl::IsNotFound(status) || absl::IsDataLoss(status)) {
      report.damaged_files.push_back(sha256);
    } else {
      return status;
    }
  }
  return report;
}

/// Whether a store has none of these files any more: they were deleted while they were to be
/// copied.
absl::StatusOr<bool> WereDeleted(const fs::path& catalogue_path,
                                 const std::vector<std::string>& files) {
  const auto catalogue = SqliteCatalogue::OpenToRead(catalogue_path);
  if (!catalogue.ok()) return catalogue.status();
  for (const std::string& sha256 : files) {
    const absl::StatusOr<bool> needed = (*catalogue)->HasFile(sha256);
    if (!needed.ok()) return needed.status();
    if (!*needed) return true;
  }
  return false;
}

/// Removes the backup's map files of which `files` has none.
absl::Status RemoveOthers(const Files& files, const fs::path& maps) {
  const absl::StatusOr<std::vector<std::string>> present = MapFolder(maps, {}).List();
  if (!present.ok()) return present.status();
  for (const std::string& sha256 : *present) {
    const bool needed = Has(files, sha256);
    absl::Status status = needed ? absl::OkStatus() : RemoveFile(MapFolder::PathIn(maps, sha256));
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status CopyIdentities(const fs::path& from, const fs::path& to) {
  const absl::Status status = CopyDatabase(from, to);
  return absl::IsNotFound(status) ? absl::OkStatus() : status;
}

std::string TimeSuffix() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return absl::StrCat(".aside-", std::chrono::duration_cast<std::chrono::seconds>(now).count());
}

/// Brings the backup's files into `staging`, but for those that the store has whole.
absl::StatusOr<BackupReport> StageFiles(const Files& files, const fs::path& backup_maps,
                                        MapFiles& present, const fs::path& staging,
                                        StoreWatcher watch) {
  BackupReport report{.file_count = static_cast<std::int64_t>(files.size()),
                      .size_bytes = TotalSize(files)};
  FileCopier copier(backup_maps, watch);
  copier.SetSize(report.size_bytes);
  for (const auto& [sha256, size_bytes] : files) {
    const absl::Status there = present.Check(sha256, [](std::size_t) { return true; });
    if (there.ok()) {
      if (!copier.Advance(size_bytes)) return absl::CancelledError("stopped");
      continue;
    }
    const absl::Status status = copier.Copy(sha256, staging / sha256);
    if (absl::IsNotFound(status) || absl::IsDataLoss(status)) {
      return absl::DataLossError(absl::StrFormat(
          "the backup's map file %s is missing or damaged; nothing was changed", sha256));
    }
    if (!status.ok()) return status;
    ++report.copied_count;
  }
  return report;
}

/// Where the state of the store changes: only renames.
absl::Status PutInPlace(const Files& files, const StorePaths& from, const fs::path& folder,
                        const fs::path& staging, MapFiles& present) {
  for (const auto& [sha256, size_bytes] : files) {
    if (!IsThere(staging / sha256)) continue;
    absl::Status status = present.Keep(staging / sha256, sha256);
    if (!status.ok()) return status;
  }
  // A catalogue that cannot be read may have been that of a store with identities.
  const bool had_identities = HasIdentityMark(folder).value_or(true);
  const fs::path catalogue = PathsOf(folder).catalogue;
  const fs::path next = staging / catalogue.filename();
  absl::Status status = CopyDatabase(from.catalogue, next);
  if (status.ok()) status = SetDatabaseAside(catalogue);
  if (status.ok()) status = MoveFile(next, catalogue);
  if (status.ok()) status = SyncFolder(folder);
  if (status.ok() && had_identities) status = SetIdentityMark(folder);
  if (!status.ok()) return status;
  const absl::StatusOr<std::vector<std::string>> all = present.List();
  if (!all.ok()) return all.status();
  for (const std::string& sha256 : *all) {
    if (Has(files, sha256)) continue;
    status.Update(present.Quarantine(sha256));
  }
  const fs::path identities = PathsOf(folder).identities;
  const absl::StatusOr<std::int64_t> size = FileSize(identities);
  status.Update(size.status());
  if (status.ok() && *size == 0) status = CopyIdentities(from.identities, identities);
  return status;
}

absl::Status CheckAreTwo(const fs::path& folder, const fs::path& backup) {
  std::error_code error;
  if (!fs::equivalent(folder, backup, error)) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(backup.string(), ": store and backup are one folder"));
}

}  // namespace

absl::StatusOr<BackupReport> BackUpStore(const fs::path& folder, const fs::path& backup,
                                         StoreWatcher watch) {
  if (absl::Status status = CheckAreTwo(folder, backup); !status.ok()) return status;
  const StorePaths from = PathsOf(folder);
  const StorePaths to = PathsOf(backup);
  if (!IsThere(from.catalogue)) {
    return absl::NotFoundError(absl::StrCat(folder.string(), ": there is no store"));
  }
  if (IsThere(to.jobs)) {
    return absl::FailedPreconditionError(
        absl::StrCat(backup.string(), ": is the store of a server, which a backup would replace"));
  }
  const absl::StatusOr<StoreLock> lock = LockStore(backup);
  if (!lock.ok()) return lock.status();
  const fs::path next = to.catalogue.string() + ".next";
  constexpr int kAttempts = 5;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    if (absl::Status status = CopyDatabase(from.catalogue, next); !status.ok()) return status;
    const absl::StatusOr<Files> files = FilesOf(next);
    if (!files.ok()) return files.status();
    absl::StatusOr<BackupReport> report = CopyNewFiles(*files, from.maps, to.maps, watch);
    if (!report.ok()) return report;
    // Then this catalogue is too old already.
    const absl::StatusOr<bool> deleted = WereDeleted(from.catalogue, report->damaged_files);
    if (!deleted.ok()) return deleted.status();
    if (*deleted) continue;
    absl::Status status = CopyIdentities(from.identities, to.identities);
    if (status.ok()) status = MoveFile(next, to.catalogue);
    if (status.ok()) status = SyncFolder(backup);
    if (status.ok()) status = RemoveOthers(*files, to.maps);
    if (!status.ok()) return status;
    return report;
  }
  return absl::FailedPreconditionError("versions are deleted faster than they are copied");
}

absl::StatusOr<BackupReport> RestoreStore(const fs::path& backup, const fs::path& folder,
                                          StoreWatcher watch) {
  if (absl::Status status = CheckAreTwo(folder, backup); !status.ok()) return status;
  const StorePaths from = PathsOf(backup);
  const absl::StatusOr<Files> files = FilesOf(from.catalogue);
  if (!files.ok()) return files.status();
  const absl::StatusOr<StoreLock> lock = LockStore(folder);
  if (!lock.ok()) return lock.status();
  const StorePaths to = PathsOf(folder);
  const auto present = MapFolder::Open(to.maps, to.quarantine);
  if (!present.ok()) return present.status();
  const fs::path staging = folder / "restoring";
  std::error_code error;
  fs::remove_all(staging, error);
  if (absl::Status made = CreateFolders(staging); !made.ok()) return made;
  absl::StatusOr<BackupReport> report = StageFiles(*files, from.maps, **present, staging, watch);
  absl::Status status = report.status();
  if (status.ok()) status = PutInPlace(*files, from, folder, staging, **present);
  fs::remove_all(staging, error);
  if (!status.ok()) return status;
  return report;
}

absl::Status SetDatabaseAside(const fs::path& database) {
  const std::string aside = database.string() + TimeSuffix();
  // The database first: beside its log alone nobody starts.
  for (const char* part : {"", "-wal", "-shm"}) {
    const fs::path path = database.string() + part;
    if (!IsThere(path)) continue;
    if (absl::Status status = MoveFile(path, aside + part); !status.ok()) return status;
  }
  return SyncFolder(database.parent_path());
}

}  // namespace dcloc::server
