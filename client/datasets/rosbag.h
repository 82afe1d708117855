#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/datasets/bag_contents.h"
#include "client/datasets/bag_mapping.h"
#include "client/datasets/bag_overview.h"
#include "client/datasets/drive.h"
#include "client/datasets/drive_request.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"

namespace dcloc {

/// The names of the bags in a folder, without ".bag", sorted.
std::vector<std::string> BagNames(const std::filesystem::path& root);

/// Where the bag `name` lies, which may end with ".bag". NotFound names the bags that there are.
absl::StatusOr<std::filesystem::path> FindBag(const std::filesystem::path& root,
                                              const std::string& name);

/// The mapping of a folder's bags: `dcloc_bag.json` beside them, else what `propose` suggests for
/// `bag`. Errors as of either; InvalidArgument where no topic of the bag can be taken
/// for a radar.
absl::StatusOr<BagMapping> MappingFor(
    const std::filesystem::path& bag,
    const std::function<BagMapping(const BagOverview&)>& propose = ProposeMapping);

/// The drive that `contents` are by `mapping`; `name` is its name, `rig_folder` where its
/// `dcloc_rig.json` may lie. The rest is as of ReadRosbagDrive.
absl::StatusOr<Drive> DriveOf(const std::string& name, const std::filesystem::path& rig_folder,
                              BagContents contents, const BagMapping& mapping,
                              const DriveRequest& request);

/// Reads the bag by `mapping` and makes the drive `name` of it.
absl::StatusOr<Drive> ReadBagAs(const std::string& name, const std::filesystem::path& bag,
                                const BagMapping& mapping, const DriveRequest& request);

/// The radar as a mapping and TF describe it: its mount, and whether it measures elevation.
/// NotFound where its frame is needed and no message names it; InvalidArgument where TF does not
/// tell where that frame sits on the vehicle.
absl::StatusOr<RadarModel> RadarOf(const RadarMapping& radar, const BagContents& contents,
                                   const std::string& vehicle_frame);

/// Puts the vehicle's own motion back into range rates over ground. InvalidArgument where the scan
/// has no ego-velocity.
absl::Status Uncompensate(const RadarModel& radar, Scan& scan);

/// Reads the bag "<root>/<request.name>.bag" of ROS 1 by `MappingFor`. Mounts are TF's; how the
/// radars measure, `dcloc_rig.json` beside the bag says where there is one. Poses are those of the
/// reference topic, or of TF from the map's frame to the vehicle's; else the odometry's, or none
/// (`Drive::pose_source`). Ego-velocities are interpolated; absent where there is none within 0.1
/// s. `Drive::notes` says what was left out, and where a bag is cut off. NotFound for a name, topic
/// or radar that is not there; other errors name the bag, the topic and what is wrong.
absl::StatusOr<Drive> ReadRosbagDrive(const std::filesystem::path& root,
                                      const DriveRequest& request);

}  // namespace dcloc
