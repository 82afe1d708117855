#include "client/datasets/drive_map.h"

#include "absl/strings/str_cat.h"
#include "core/odometry/ego_motion.h"
#include "core/online_calibration/drive_stamps.h"

namespace dcloc {

namespace {

// How late radars stamp their scans is known at the end of the drive only.
MeasuredStamps StampsOf(const Drive& drive) {
  DriveStamps stamps(drive.rig);
  if (!stamps.IsNeeded()) return {.rig = drive.rig};
  for (const auto& posed : drive.scans) stamps.Add(posed.scan);
  return stamps.Measured();
}

}  // namespace

absl::StatusOr<std::vector<std::byte>> BuildMap(const Drive& drive,
                                                const MapBuilderOptions& options,
                                                const std::function<void(std::size_t)>& progress) {
  if (drive.pose_source == PoseSource::kNone) return CheckHasReference(drive, "a map");
  if (absl::Status status = CheckRadarsOfScans(drive); !status.ok()) return status;
  const MeasuredStamps stamps = StampsOf(drive);
  const Rig& rig = stamps.rig;
  MapBuilderOptions with_delay = options;
  with_delay.stamp_delay_s = stamps.mean_delay_s;
  auto builder = MapBuilder::Create(rig, with_delay);
  if (!builder.ok()) return builder.status();
  EgoMotion ego_motion;
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    const auto& [scan, T_map_vehicle] = drive.scans[i];
    const EgoVelocity& velocity = ego_motion.Advance(scan, *rig.Find(scan.radar_id));
    if (absl::Status status = builder->Add(scan, T_map_vehicle, velocity); !status.ok()) {
      return absl::Status(status.code(), absl::StrCat(drive.name, ", scan ", i, " of ",
                                                      scan.radar_id, ": ", status.message()));
    }
    progress(i + 1);
  }
  return builder->Build();
}

}  // namespace dcloc
