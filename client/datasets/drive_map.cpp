#include "client/datasets/drive_map.h"

#include "absl/strings/str_cat.h"
#include "core/odometry/ego_motion.h"

namespace dcloc {

absl::StatusOr<std::vector<std::byte>> BuildMap(const Drive& drive,
                                                const MapBuilderOptions& options,
                                                const std::function<void(std::size_t)>& progress) {
  if (drive.pose_source == PoseSource::kNone) return CheckHasReference(drive, "a map");
  auto builder = MapBuilder::Create(drive.rig, options);
  if (!builder.ok()) return builder.status();
  if (absl::Status status = CheckRadarsOfScans(drive); !status.ok()) return status;
  EgoMotion ego_motion;
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    const auto& [scan, T_map_vehicle] = drive.scans[i];
    const EgoVelocity& velocity = ego_motion.Advance(scan, *drive.rig.Find(scan.radar_id));
    if (absl::Status status = builder->Add(scan, T_map_vehicle, velocity); !status.ok()) {
      return absl::Status(status.code(), absl::StrCat(drive.name, ", scan ", i, " of ",
                                                      scan.radar_id, ": ", status.message()));
    }
    progress(i + 1);
  }
  return builder->Build();
}

}  // namespace dcloc
