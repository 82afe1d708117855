#include "client/datasets/finish_drive.h"

#include <algorithm>
#include <tuple>

#include "absl/strings/str_cat.h"

namespace dcloc {

absl::Status FinishDrive(const DriveRequest& request, Drive& drive) {
  for (RadarModel& radar : drive.rig.radars) radar.beta_s = request.beta_s.value_or(radar.beta_s);
  if (absl::Status status = Validate(drive.rig); !status.ok()) return status;

  const auto key = [](const DriveScan& entry) {
    return std::tie(entry.scan.stamp, entry.scan.radar_id);
  };
  std::sort(drive.scans.begin(), drive.scans.end(),
            [&](const DriveScan& a, const DriveScan& b) { return key(a) < key(b); });
  const auto twice =
      std::adjacent_find(drive.scans.begin(), drive.scans.end(),
                         [&](const DriveScan& a, const DriveScan& b) { return key(a) == key(b); });
  if (twice != drive.scans.end()) {
    return absl::InvalidArgumentError(
        absl::StrCat(twice->scan.radar_id, " has two scans of one stamp, ",
                     twice->scan.stamp.time_since_epoch().count(), " ns"));
  }
  for (const DriveScan& entry : drive.scans) {
    if (!entry.scan.ego_velocity.has_value()) continue;
    if (absl::Status status = Validate(*entry.scan.ego_velocity); !status.ok()) {
      return absl::InvalidArgumentError(absl::StrCat("ego-velocity at ",
                                                     entry.scan.stamp.time_since_epoch().count(),
                                                     " ns: ", status.message()));
    }
  }
  return absl::OkStatus();
}

}  // namespace dcloc
