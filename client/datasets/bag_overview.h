#pragma once

#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/datasets/bag_mapping.h"
#include "client/rosbag/bag_reader.h"
#include "client/rosbag/messages.h"

namespace dcloc {

/// The stamps in a topic's headers, in the order of its messages.
struct BagStamps {
  std::int64_t count = 0;
  Stamp first;                      ///< the earliest
  Stamp last;                       ///< the latest
  Stamp previous;                   ///< of the last message
  std::int64_t backward_count = 0;  ///< that lie before the one before them
  std::int64_t repeated_count = 0;  ///< that are the one before them
  double longest_gap_s = 0.0;
  double least_delay_s = 0.0;  ///< from a stamp to the recorder's clock when it came
  double greatest_delay_s = 0.0;
};

/// What a bag holds of one topic.
struct BagTopic {
  rosbag::Connection connection;
  std::int64_t message_count = 0;
  Stamp first_record;
  Stamp last_record;
  BagStamps stamps;                 ///< of types with a header that are known
  std::string frame;                ///< of the first message, where its type has one
  std::string child_frame;          ///< of the first Odometry
  std::vector<std::string> fields;  ///< of the first point cloud
  bool has_height = false;          ///< a point of one of the first clouds has a z that is not 0
  std::string fault;                ///< why the topic is not read; empty where it is
};

struct BagOverview {
  rosbag::BagSummary summary;
  std::vector<BagTopic> topics;  ///< by name
  std::set<std::string> frames;  ///< that TF knows

  const BagTopic* Find(const std::string& topic) const;
};

/// Looks through a bag without keeping its messages. Errors are those of rosbag::ReadBag.
absl::StatusOr<BagOverview> ReadBagOverview(const std::filesystem::path& path);

/// The mapping that names and types suggest, by the field names of common radar drivers (README).
/// Radars without a field that is known as a range rate are left out; so it may have no radar.
BagMapping ProposeMapping(const BagOverview& overview);

}  // namespace dcloc
