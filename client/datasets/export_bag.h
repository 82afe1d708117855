#pragma once

#include <filesystem>

#include "absl/status/status.h"
#include "client/datasets/drive.h"
#include "client/rosbag/compression.h"

namespace dcloc {

/// Writes a drive as a bag of ROS 1 from which `ReadRosbagDrive` gives the same drive, to the bit:
/// /radar/ID/points (PointCloud2), /vehicle/velocity (TwistWithCovarianceStamped), /tf_static with
/// the mounts, and /tf with the reference poses. How the radars measure goes to `dcloc_rig.json`
/// beside it. FailedPrecondition where that file is there and says something else, or targets have
/// sigmas of their own, which our point clouds have not. Other errors name the path; after any, an
/// older bag is as it was.
absl::Status ExportBag(const Drive& drive, const std::filesystem::path& path,
                       rosbag::Compression compression);

}  // namespace dcloc
