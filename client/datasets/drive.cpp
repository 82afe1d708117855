#include "client/datasets/drive.h"

#include "absl/strings/str_cat.h"

namespace dcloc {

absl::Status CheckRadarsOfScans(const Drive& drive) {
  for (const DriveScan& entry : drive.scans) {
    if (drive.rig.Find(entry.scan.radar_id) != nullptr) continue;
    return absl::InvalidArgumentError(absl::StrCat("drive ", drive.name, " has a scan of radar '",
                                                   entry.scan.radar_id,
                                                   "', which its rig does not describe"));
  }
  return absl::OkStatus();
}

}  // namespace dcloc
