#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/datasets/bag_mapping.h"
#include "client/rosbag/bag_reader.h"
#include "client/rosbag/messages.h"
#include "client/rosbag/transform_tree.h"
#include "core/radar/scan.h"

namespace dcloc {

/// The messages of a bag that a mapping names.
struct BagContents {
  rosbag::BagSummary summary;
  std::vector<Scan> scans;                    ///< as they come, without ego-velocity
  std::map<std::string, std::string> frames;  ///< of the radars, by id
  std::vector<rosbag::Motion> motions;        ///< of `motion_topic`, by ascending stamp
  std::vector<rosbag::ImuSample> turn_rates;  ///< of `imu_topic`, by ascending stamp
  std::vector<rosbag::Motion> references;     ///< of `reference_topic`, by ascending stamp
  std::vector<rosbag::SatelliteFix> fixes;    ///< of `reference_topic`, where it is of fixes
  rosbag::TransformTree transforms;
};

/// Reads them. Targets that are not finite, or have no range, are left out; range rates are made to
/// be positive for what recedes, but those that are compensated stay so. Errors name the path:
/// those of rosbag::ReadBag, NotFound for a topic that is not there, InvalidArgument for one of
/// another type, DataLoss for a message or a field that cannot be read.
absl::StatusOr<BagContents> ReadBagContents(const std::filesystem::path& path,
                                            const BagMapping& mapping);

}  // namespace dcloc
