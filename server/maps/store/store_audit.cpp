#include "server/maps/store/store_audit.h"

#include "server/maps/store/store_check.h"

namespace dcloc::server {
namespace {

/// Adds a file to the list in which its fault belongs.
absl::Status Judge(Catalogue& catalogue, const std::string& sha256, const absl::Status& fault,
                   StoreAudit* audit) {
  if (fault.ok()) return fault;
  if (!absl::IsNotFound(fault) && !absl::IsDataLoss(fault) && !absl::IsInternal(fault)) {
    return fault;
  }
  const absl::StatusOr<bool> needed = catalogue.HasFile(sha256);
  if (!needed.ok()) return needed.status();
  if (!*needed) return absl::OkStatus();  // deleted meanwhile
  (absl::IsNotFound(fault) ? audit->missing_files : audit->damaged_files).push_back(sha256);
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<StoreAudit> AuditStore(Catalogue& catalogue, MapFiles& files, StoreWatcher watch) {
  StoreAudit audit;
  absl::StatusOr<std::vector<std::string>> unaccounted = UnaccountedFiles(catalogue, files);
  if (!unaccounted.ok()) return unaccounted.status();
  audit.unaccounted_files = *std::move(unaccounted);
  const absl::StatusOr<int> quarantined = files.QuarantinedCount();
  if (!quarantined.ok()) return quarantined.status();
  audit.quarantined_count = *quarantined;
  const auto wanted = catalogue.ListFiles();
  if (!wanted.ok()) return wanted.status();
  for (const auto& [sha256, size_bytes] : *wanted) audit.size_bytes += size_bytes;
  StoreProgress progress{.size_bytes = audit.size_bytes};
  for (const auto& [sha256, size_bytes] : *wanted) {
    const absl::Status fault = files.Check(sha256, [&](std::size_t piece_bytes) {
      progress.done_bytes += static_cast<std::int64_t>(piece_bytes);
      return watch(progress);
    });
    if (absl::Status status = Judge(catalogue, sha256, fault, &audit); !status.ok()) return status;
    ++audit.file_count;
  }
  return audit;
}

}  // namespace dcloc::server
