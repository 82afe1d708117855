#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <set>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "core/radar/stamp.h"

namespace dcloc::rosbag {

/// What was written under one topic by one publisher.
struct Connection {
  std::string topic;
  std::string type;    ///< "sensor_msgs/PointCloud2"
  std::string md5sum;  ///< of the type's definition
};

/// A message as it lies in the bag; valid during the call that gets it.
struct Message {
  const Connection& connection;
  Stamp record_time;       ///< when it came to the recorder
  absl::string_view data;  ///< serialized
};

/// What is known of a bag once it was read.
struct BagSummary {
  bool has_index = false;
  std::int64_t message_count = 0;
  std::set<std::string> compressions;
  /// Where the file is cut off, in bytes from its beginning; what lies before has been read.
  std::int64_t cut_at = -1;

  bool is_cut() const { return cut_at >= 0; }
};

/// Reads the messages of a ROS 1 bag (format 2.0) in the order in which they lie in it. The index
/// is not used, so that a bag without one is read as well, and one that is cut off up to the last
/// whole record. Errors name the path: NotFound and the like, InvalidArgument for what is no bag of
/// ROS 1, DataLoss for a damaged one, and what `visit` returns.
absl::StatusOr<BagSummary> ReadBag(const std::filesystem::path& path,
                                   const std::function<absl::Status(const Message&)>& visit);

}  // namespace dcloc::rosbag
