#pragma once

#include <filesystem>
#include <string>

#include "client/datasets/bag_presets.h"
#include "client/datasets/drive.h"

namespace dcloc {

/// Where the mount of the set's radar is, as the preset has it; of MSC-RAD4R the identity.
Pose3 MountInSet(BagSet set);

/// Writes a drive of one radar as `set` has it: the bag `root`/`name`.bag with clouds and turn
/// rates, and poses in a text file, or as satellite fixes about 36.25 N, 127.25 E. The body of the
/// set is the one on which the radar has its place; of MSC-RAD4R the drive's vehicle.
void WriteBagSet(BagSet set, const Drive& drive, const std::filesystem::path& root,
                 const std::string& name);

}  // namespace dcloc
