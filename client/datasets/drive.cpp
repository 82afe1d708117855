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

absl::Status CheckHasReference(const Drive& drive, absl::string_view purpose) {
  if (drive.pose_source == PoseSource::kReference) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat("drive ", drive.name, " has no reference poses, which ", purpose, " needs"));
}

}  // namespace dcloc
