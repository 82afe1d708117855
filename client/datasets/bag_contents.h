#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "absl/status/status.h"
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
  rosbag::TransformTree transforms;
};

/// Takes messages one at a time, from a bag or as they come. Targets that are not finite, or have
/// no range, are left out; range rates are made to be positive for what recedes, but those that are
/// compensated stay so.
class BagCollector {
 public:
  /// Both outlive it.
  BagCollector(const BagMapping& mapping, BagContents& contents)
      : mapping_(mapping), contents_(contents) {}

  /// Puts what `message` says behind what is there, where the mapping names its topic or it is of
  /// TF. InvalidArgument for another type, DataLoss for a message or a field that cannot be read;
  /// both name the topic.
  absl::Status Take(const rosbag::Message& message);

  /// NotFound unless each topic of the mapping was there.
  absl::Status CheckSeen() const;

 private:
  absl::Status TakeScan(const RadarMapping& radar, const rosbag::Message& message);
  absl::Status TakeTransforms(const rosbag::Message& message);
  absl::Status TakeTurnRate(const rosbag::Message& message);

  const BagMapping& mapping_;
  BagContents& contents_;
  std::set<std::string> seen_;
};

/// Sorts motions, turn rates, references and transforms by stamp, as `BagMotion` needs them.
void SortByStamp(BagContents& contents);

/// Reads them, sorted by stamp. Errors name the path: those of rosbag::ReadBag and of BagCollector.
absl::StatusOr<BagContents> ReadBagContents(const std::filesystem::path& path,
                                            const BagMapping& mapping);

}  // namespace dcloc
