#include "server/maps/store/orphan_file.h"

namespace dcloc::server {

absl::StatusOr<bool> RemoveOrphan(Catalogue& catalogue, MapFiles& files, absl::string_view sha256,
                                  absl::string_view holder) {
  const absl::StatusOr<Hold> hold = catalogue.HoldFile(sha256, holder);
  if (absl::IsUnavailable(hold.status())) return false;
  if (!hold.ok()) return hold.status();
  const absl::StatusOr<bool> needed = catalogue.HasFile(sha256);
  if (!needed.ok()) return needed.status();
  if (*needed) return false;
  if (absl::Status status = files.Remove(sha256); !status.ok()) return status;
  return true;
}

}  // namespace dcloc::server
