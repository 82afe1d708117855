#include "server/maps/store/orphan_file.h"

namespace dcloc::server {
namespace {

/// Calls `take_away` if no version has the file and nobody holds it.
template <typename TakeAway>
absl::StatusOr<bool> TakeOrphan(Catalogue& catalogue, absl::string_view sha256,
                                absl::string_view holder, const TakeAway& take_away) {
  const absl::StatusOr<Hold> hold = catalogue.HoldFile(sha256, holder);
  if (absl::IsUnavailable(hold.status())) return false;
  if (!hold.ok()) return hold.status();
  const absl::StatusOr<bool> needed = catalogue.HasFile(sha256);
  if (!needed.ok()) return needed.status();
  if (*needed) return false;
  absl::Status status = take_away();
  if (status.ok()) status = catalogue.RemoveLooseFile(sha256);
  if (!status.ok()) return status;
  return true;
}

}  // namespace

absl::StatusOr<bool> RemoveOrphan(Catalogue& catalogue, MapFiles& files, absl::string_view sha256,
                                  absl::string_view holder) {
  return TakeOrphan(catalogue, sha256, holder, [&] { return files.Remove(sha256); });
}

absl::StatusOr<bool> QuarantineOrphan(Catalogue& catalogue, MapFiles& files,
                                      absl::string_view sha256, absl::string_view holder) {
  return TakeOrphan(catalogue, sha256, holder, [&] { return files.Quarantine(sha256); });
}

}  // namespace dcloc::server
