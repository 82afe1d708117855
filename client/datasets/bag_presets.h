#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/datasets/bag_mapping.h"
#include "client/datasets/drive.h"
#include "client/datasets/drive_request.h"

namespace dcloc {

/// Public data sets whose drives are bags of ROS 1, in folders below the data set's (decision
/// 0090).
enum class BagSet { kSnailRadar, kNtu4dRadLm, kMscRad4r };

/// The bags at most three folders below `root`, by their path from there without ".bag", sorted:
/// "20240123/data3". Bags of reference poses alone (gt_odom.bag) are left out.
std::vector<std::string> BagSetDrives(const std::filesystem::path& root);

/// Where the bag of a drive lies. NotFound names the drives that there are.
absl::StatusOr<std::filesystem::path> FindBagOfSet(const std::filesystem::path& root,
                                                   const std::string& name);

/// The mapping of a bag: `dcloc_bag.json` beside it, else the set's own: topics, fields, mounts and
/// poses as its authors document them, as far as the bag has them. Errors are those of MappingFor.
absl::StatusOr<BagMapping> MappingOfSet(BagSet set, const std::filesystem::path& root,
                                        const std::filesystem::path& bag);

/// Reads the drive `request.name` by that mapping. Errors are those of ReadRosbagDrive.
absl::StatusOr<Drive> ReadBagSetDrive(BagSet set, const std::filesystem::path& root,
                                      const DriveRequest& request);

}  // namespace dcloc
