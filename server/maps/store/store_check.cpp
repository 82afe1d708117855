#include "server/maps/store/store_check.h"

#include <map>
#include <memory>
#include <utility>

#include "server/maps/catalogue/coverage.h"
#include "server/maps/store/orphan_file.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

absl::Status CheckIncoming(IncomingFiles& incoming, SystemTime stale_before, StoreReport* report) {
  report->removed_leftover_count = incoming.removed_count();
  const absl::StatusOr<int> stale = incoming.RemoveUntouchedSince(stale_before);
  if (!stale.ok()) return stale.status();
  report->stale_upload_count = *stale;
  const absl::StatusOr<int> left = incoming.Count();
  if (!left.ok()) return left.status();
  report->unfinished_upload_count = *left;
  return absl::OkStatus();
}

absl::Status CheckFiles(Catalogue& catalogue, MapFiles& files, absl::string_view holder,
                        StoreReport* report) {
  const absl::StatusOr<std::vector<std::pair<std::string, std::int64_t>>> wanted =
      catalogue.ListFiles();
  if (!wanted.ok()) return wanted.status();
  const std::map<std::string, std::int64_t> sizes(wanted->begin(), wanted->end());
  const absl::StatusOr<std::vector<std::string>> present = files.List();
  if (!present.ok()) return present.status();
  for (const std::string& sha256 : *present) {
    if (sizes.contains(sha256)) continue;
    const absl::StatusOr<bool> removed = RemoveOrphan(catalogue, files, sha256, holder);
    if (!removed.ok()) return removed.status();
    report->removed_map_file_count += *removed ? 1 : 0;
  }
  for (const auto& [sha256, size_bytes] : sizes) {
    const absl::StatusOr<std::int64_t> size = files.SizeOf(sha256);
    if (!size.ok()) return size.status();
    if (*size != size_bytes) report->broken_files.push_back(sha256);
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

absl::StatusOr<StoreReport> CheckStore(Catalogue& catalogue, MapFiles& files,
                                       IncomingFiles& incoming, SystemTime stale_before,
                                       absl::string_view holder) {
  StoreReport report;
  absl::Status status = CheckIncoming(incoming, stale_before, &report);
  if (status.ok()) status = CheckFiles(catalogue, files, holder, &report);
  if (status.ok()) status = CoverTheRest(catalogue, files, &report);
  if (!status.ok()) return status;
  return report;
}

void Log(const StoreReport& report) {
  if (report.removed_leftover_count + report.removed_map_file_count > 0) {
    spdlog::info("store repaired removed_leftovers={} removed_map_files={}",
                 report.removed_leftover_count, report.removed_map_file_count);
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
