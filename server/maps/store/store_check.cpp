#include "server/maps/store/store_check.h"

#include <algorithm>
#include <memory>
#include <set>
#include <utility>

#include "absl/strings/str_format.h"
#include "server/base/status.h"
#include "server/maps/catalogue/coverage.h"
#include "server/maps/store/orphan_file.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

absl::Status CheckIncoming(IncomingFiles& incoming, std::chrono::nanoseconds stale_age,
                           StoreReport* report) {
  report->removed_leftover_count = incoming.removed_count();
  const absl::StatusOr<int> stale = incoming.RemoveStale({}, stale_age);
  if (!stale.ok()) return stale.status();
  report->stale_upload_count = *stale;
  const absl::StatusOr<int> left = incoming.Count();
  if (!left.ok()) return left.status();
  report->unfinished_upload_count = *left;
  return absl::OkStatus();
}

/// Those of `present`, which were listed before, for which the catalogue cannot account.
absl::StatusOr<std::vector<std::string>> UnaccountedOf(std::vector<std::string> present,
                                                       Catalogue& catalogue, MapFiles& files) {
  const absl::StatusOr<std::vector<std::string>> loose = catalogue.ListLooseFiles();
  if (!loose.ok()) return loose.status();
  const auto wanted = catalogue.ListFiles();
  if (!wanted.ok()) return wanted.status();
  std::set<std::string> known(loose->begin(), loose->end());
  for (const auto& [sha256, size_bytes] : *wanted) known.insert(sha256);
  std::erase_if(present, [&](const std::string& sha256) { return known.contains(sha256); });
  if (present.empty()) return present;
  // One may have been removed meanwhile by a process that deleted its version.
  const absl::StatusOr<std::vector<std::string>> still_present = files.List();
  if (!still_present.ok()) return still_present.status();
  const std::set<std::string> still(still_present->begin(), still_present->end());
  std::erase_if(present, [&](const std::string& sha256) { return !still.contains(sha256); });
  std::ranges::sort(present);
  return present;
}

absl::Status CheckAccounted(std::vector<std::string> present, Catalogue& catalogue,
                            MapFiles& files) {
  const absl::StatusOr<std::vector<std::string>> unaccounted =
      UnaccountedOf(std::move(present), catalogue, files);
  if (!unaccounted.ok()) return unaccounted.status();
  if (unaccounted->empty()) return absl::OkStatus();
  const auto known = catalogue.ListFiles();
  if (!known.ok()) return known.status();
  return absl::FailedPreconditionError(absl::StrFormat(
      "the catalogue, which has %d map files, knows nothing of %d that are there (first: %s): it "
      "is missing, older than they are, or that of another store",
      known->size(), unaccounted->size(), unaccounted->front()));
}

absl::Status FindBroken(Catalogue& catalogue, MapFiles& files, StoreReport* report) {
  const auto wanted = catalogue.ListFiles();
  if (!wanted.ok()) return wanted.status();
  for (const auto& [sha256, size_bytes] : *wanted) {
    const absl::StatusOr<std::int64_t> size = files.SizeOf(sha256);
    if (!size.ok() && !absl::IsDataLoss(size.status())) return size.status();
    if (size.ok() && *size == size_bytes) continue;
    // Another process may have deleted its version meanwhile.
    const absl::StatusOr<bool> needed = catalogue.HasFile(sha256);
    if (!needed.ok()) return needed.status();
    if (*needed) report->broken_files.push_back(sha256);
  }
  return absl::OkStatus();
}

absl::Status CoverTheRest(Catalogue& catalogue, MapFiles& files, StoreReport* report) {
  const absl::StatusOr<std::vector<MapVersionRecord>> uncovered = catalogue.ListUncovered();
  if (!uncovered.ok()) return uncovered.status();
  for (const MapVersionRecord& record : *uncovered) {
    const absl::StatusOr<std::shared_ptr<const RadarMap>> map = files.Open(record.sha256);
    if (!map.ok()) continue;  // among the broken ones
    absl::Status status = catalogue.AddCoverage(record.map_name, record.version, CoverageOf(**map));
    if (!status.ok()) return status;
    ++report->covered_version_count;
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::vector<std::string>> UnaccountedFiles(Catalogue& catalogue, MapFiles& files) {
  // The files first: what another process stores meanwhile is announced before it is there.
  absl::StatusOr<std::vector<std::string>> present = files.List();
  if (!present.ok()) return present;
  return UnaccountedOf(*std::move(present), catalogue, files);
}

absl::StatusOr<int> SetLooseFilesAside(Catalogue& catalogue, MapFiles& files,
                                       absl::string_view holder) {
  const absl::StatusOr<std::vector<std::string>> loose = catalogue.ListLooseFiles();
  if (!loose.ok()) return loose.status();
  int count = 0;
  for (const std::string& sha256 : *loose) {
    const absl::StatusOr<std::int64_t> size = files.SizeOf(sha256);
    if (!size.ok() && !absl::IsDataLoss(size.status())) return size.status();
    const bool is_there = !size.ok() || *size > 0;  // if only as something that is no file
    const absl::StatusOr<bool> done = !is_there
                                          ? RemoveOrphan(catalogue, files, sha256, holder)
                                          : QuarantineOrphan(catalogue, files, sha256, holder);
    if (!done.ok()) {
      // A full disk is no reason not to start: the next time tries again.
      spdlog::warn("map file not set aside sha256={} reason={}", sha256,
                   Quoted(done.status().message()));
      continue;
    }
    count += *done && is_there ? 1 : 0;
  }
  return count;
}

absl::StatusOr<StoreReport> CheckStore(Catalogue& catalogue, MapFiles& files,
                                       IncomingFiles& incoming, std::chrono::nanoseconds stale_age,
                                       absl::string_view holder) {
  StoreReport report;
  absl::StatusOr<std::vector<std::string>> present = files.List();
  report.files_away = absl::IsUnavailable(present.status());
  if (!present.ok() && !report.files_away) return present.status();
  absl::Status status;
  if (!report.files_away) status = CheckAccounted(*std::move(present), catalogue, files);
  if (status.ok()) status = CheckIncoming(incoming, stale_age, &report);
  if (status.ok() && report.files_away) return report;
  if (status.ok()) {
    const absl::StatusOr<int> set_aside = SetLooseFilesAside(catalogue, files, holder);
    report.quarantined_file_count = set_aside.value_or(0);
    status = set_aside.status();
  }
  if (status.ok()) status = FindBroken(catalogue, files, &report);
  if (status.ok()) status = CoverTheRest(catalogue, files, &report);
  if (!status.ok()) return status;
  return report;
}

void Log(const StoreReport& report) {
  if (report.files_away) spdlog::warn("map files not checked, their storage is away");
  if (report.removed_leftover_count + report.quarantined_file_count > 0) {
    spdlog::info("store repaired removed_leftovers={} quarantined_map_files={}",
                 report.removed_leftover_count, report.quarantined_file_count);
  }
  if (report.stale_upload_count + report.unfinished_upload_count > 0) {
    spdlog::info("unfinished uploads kept={} removed={}", report.unfinished_upload_count,
                 report.stale_upload_count);
  }
  if (report.covered_version_count > 0) {
    spdlog::info("coverage noted versions={}", report.covered_version_count);
  }
  for (const std::string& sha256 : report.broken_files) {
    spdlog::error("map file missing or cut short sha256={}", sha256);
  }
}

}  // namespace dcloc::server
