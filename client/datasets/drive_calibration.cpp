#include "client/datasets/drive_calibration.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "core/odometry/ego_motion.h"

namespace dcloc {

absl::Status AddDrive(const Drive& drive, Calibrator& calibrator,
                      const std::function<void(std::size_t)>& progress) {
  if (absl::Status status = CheckHasReference(drive, "calibration"); !status.ok()) return status;
  const std::string& frame = drive.place.empty() ? drive.name : drive.place;
  EgoMotion ego_motion;
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    const auto& [scan, T_map_vehicle] = drive.scans[i];
    const EgoVelocity& velocity = ego_motion.Advance(scan, *drive.rig.Find(scan.radar_id));
    if (absl::Status status = calibrator.Add(frame, scan, T_map_vehicle, velocity); !status.ok()) {
      return absl::Status(status.code(), absl::StrCat(drive.name, ", scan ", i, " of ",
                                                      scan.radar_id, ": ", status.message()));
    }
    progress(i + 1);
  }
  return absl::OkStatus();
}

}  // namespace dcloc
