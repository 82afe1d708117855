#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/datasets/drive.h"
#include "client/datasets/drive_request.h"

namespace dcloc {

/// The ids of ZOD's sequences and drives that trainval-{sequences,drives}-*.json in `root` list,
/// sorted; none where there is no such file or it cannot be read.
std::vector<std::string> ZodDrives(const std::filesystem::path& root);

/// Reads the front radar of the sequence or drive `request.name`: one NumPy table of all its scans,
/// the mount of its calibration.json, poses and velocities of its ego_motion.json. Poses are tied
/// to the Earth by `origin_lat_lon`, in the frame of SharedAnchor (fix_poses.h). NotFound for what
/// is not there, DataLoss that names the file and the field.
absl::StatusOr<Drive> ReadZodDrive(const std::filesystem::path& root, const DriveRequest& request);

}  // namespace dcloc
