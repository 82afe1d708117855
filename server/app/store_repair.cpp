#include "server/app/store_repair.h"

#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/app/storage.h"
#include "server/app/store_backup.h"
#include "server/base/files.h"
#include "server/base/sqlite_copy.h"
#include "server/maps/catalogue/coverage.h"
#include "server/maps/catalogue/sqlite_catalogue.h"
#include "server/maps/store/map_folder.h"
#include "server/maps/store/orphan_file.h"
#include "server/maps/store/store_check.h"

namespace dcloc::server {
namespace {

constexpr char kRepairer[] = "dcloc-server store repair";
constexpr std::size_t kShownDigits = 12;

/// The store's catalogue, or a new one in place of what is none.
absl::StatusOr<std::unique_ptr<SqliteCatalogue>> OpenOrReplace(const std::filesystem::path& folder,
                                                               RepairReport* report) {
  const std::filesystem::path path = PathsOf(folder).catalogue;
  if (IsThere(path)) {
    absl::Status status = CheckDatabase(path);
    if (status.ok()) {
      auto catalogue = SqliteCatalogue::Open(path);
      if (catalogue.ok() || !absl::IsDataLoss(catalogue.status())) return catalogue;
      status = catalogue.status();
    }
    if (!absl::IsDataLoss(status)) return status;
  }
  report->catalogue_replaced = true;
  if (absl::Status status = SetDatabaseAside(path); !status.ok()) return status;
  return SqliteCatalogue::Open(path);
}

/// Makes a file that no version has a map of its own; false when it is no intact map.
absl::StatusOr<bool> Adopt(Catalogue& catalogue, MapFiles& files, const std::string& sha256) {
  const absl::StatusOr<std::shared_ptr<const RadarMap>> map = files.Open(sha256);
  if (absl::IsDataLoss(map.status())) return false;
  if (!map.ok()) return map.status();
  const std::string name = absl::StrCat("recovered-", sha256.substr(0, kShownDigits));
  const absl::Status status =
      catalogue.AddVersion(name, sha256, (*map)->info(), CoverageOf(**map)).status();
  if (!status.ok()) return status;
  return true;
}

absl::Status PlaceUnaccounted(Catalogue& catalogue, MapFiles& files, const RepairOptions& options,
                              RepairReport* report) {
  const absl::StatusOr<std::vector<std::string>> unaccounted = UnaccountedFiles(catalogue, files);
  if (!unaccounted.ok()) return unaccounted.status();
  for (const std::string& sha256 : *unaccounted) {
    const absl::StatusOr<bool> adopted =
        options.adopt ? Adopt(catalogue, files, sha256) : absl::StatusOr<bool>(false);
    if (!adopted.ok()) return adopted.status();
    report->adopted_count += *adopted ? 1 : 0;
    if (*adopted) continue;
    absl::Status status = QuarantineOrphan(catalogue, files, sha256, kRepairer).status();
    if (!status.ok()) return status;
    ++report->quarantined_count;
  }
  return absl::OkStatus();
}

/// Builds that wait and passes that were kept: without them a server starts, and nobody is let in.
absl::Status SetAsideIfDamaged(const std::filesystem::path& database, RepairReport* report) {
  absl::Status status = CheckDatabase(database);
  if (status.ok() || absl::IsNotFound(status)) return absl::OkStatus();
  if (!absl::IsDataLoss(status)) return status;
  report->set_aside.push_back(database.filename().string());
  return SetDatabaseAside(database);
}

/// A folder that is named by mistake is left as it is.
absl::Status CheckIsStore(const std::filesystem::path& folder) {
  const StorePaths paths = PathsOf(folder);
  if (IsThere(paths.catalogue)) return absl::OkStatus();
  const absl::StatusOr<std::vector<std::string>> files =
      MapFolder(paths.maps, paths.quarantine).List();
  if (!files.ok()) return files.status();
  if (!files->empty()) return absl::OkStatus();
  return absl::NotFoundError(
      absl::StrCat(folder.string(), ": there is no store, neither a catalogue nor map files"));
}

}  // namespace

absl::StatusOr<RepairReport> RepairStore(const std::filesystem::path& folder,
                                         const RepairOptions& options, StoreWatcher watch) {
  if (absl::Status status = CheckIsStore(folder); !status.ok()) return status;
  const absl::StatusOr<StoreLock> lock = LockStore(folder);
  if (!lock.ok()) return lock.status();
  RepairReport report;
  const auto catalogue = OpenOrReplace(folder, &report);
  if (!catalogue.ok()) return catalogue.status();
  const StorePaths paths = PathsOf(folder);
  const auto files = MapFolder::Open(paths.maps, paths.quarantine);
  if (!files.ok()) return files.status();
  absl::Status status = SetAsideIfDamaged(paths.jobs, &report);
  if (status.ok()) status = SetAsideIfDamaged(paths.passes, &report);
  if (status.ok()) status = PlaceUnaccounted(**catalogue, **files, options, &report);
  if (!status.ok()) return status;
  absl::StatusOr<StoreAudit> audit = AuditStore(**catalogue, **files, watch);
  if (!audit.ok()) return audit.status();
  report.audit = *std::move(audit);
  return report;
}

}  // namespace dcloc::server
