#include "client/datasets/bag_overview.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <map>
#include <span>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_split.h"
#include "client/rosbag/message_reader.h"
#include "client/rosbag/message_types.h"

namespace dcloc {
namespace {

using rosbag::Message;

constexpr std::int64_t kCloudsLookedAt = 5;
constexpr double kFlat_m = 1e-6;

absl::Status LookAtCloud(const Message& message, BagTopic& topic) {
  if (topic.message_count > kCloudsLookedAt) return absl::OkStatus();
  const absl::StatusOr<rosbag::PointCloud> cloud =
      rosbag::ParseCloudOf(message.connection.type, message.data);
  if (!cloud.ok()) return cloud.status();
  topic.frame = cloud->header.frame_id;
  topic.fields.clear();
  for (const rosbag::PointField& field : cloud->fields) topic.fields.push_back(field.name);
  const rosbag::PointField* const z = cloud->Find("z");
  for (std::size_t i = 0; z != nullptr && i < cloud->point_count; ++i) {
    topic.has_height = topic.has_height || std::abs(cloud->Value(*z, i)) > kFlat_m;
  }
  return absl::OkStatus();
}

absl::Status LookAt(const Message& message, BagTopic& topic, BagOverview& overview) {
  const std::string& type = message.connection.type;
  if (rosbag::IsPointCloud(type)) return LookAtCloud(message, topic);
  if (type == rosbag::kTf2.name || type == rosbag::kTf.name) {
    const auto transforms = rosbag::ParseTransforms(message.data);
    if (!transforms.ok()) return transforms.status();
    for (const rosbag::Transform& transform : *transforms) {
      overview.frames.insert({transform.parent, transform.child});
    }
    return absl::OkStatus();
  }
  if (topic.message_count > 1) return absl::OkStatus();
  if (type == rosbag::kImu.name) {
    const auto sample = rosbag::ParseImu(message.data);
    if (sample.ok()) topic.frame = sample->header.frame_id;
    return sample.status();
  }
  if (type == rosbag::kNavSatFix.name) return rosbag::ParseSatelliteFix(message.data).status();
  const auto motion = rosbag::ParseMotion(type, message.data);
  if (!motion.ok()) return motion.status();
  topic.frame = motion->header.frame_id;
  topic.child_frame = motion->child_frame;
  return absl::OkStatus();
}

double SecondsBetween(Stamp begin, Stamp end) {
  return std::chrono::duration<double>(end - begin).count();
}

void TakeStamp(Stamp stamp, Stamp record_time, BagStamps& stamps) {
  const double delay_s = SecondsBetween(stamp, record_time);
  if (stamps.count++ == 0) {
    stamps.first = stamps.last = stamp;
    stamps.least_delay_s = stamps.greatest_delay_s = delay_s;
  } else {
    stamps.backward_count += stamp < stamps.previous ? 1 : 0;
    stamps.repeated_count += stamp == stamps.previous ? 1 : 0;
    stamps.longest_gap_s = std::max(stamps.longest_gap_s, SecondsBetween(stamps.previous, stamp));
  }
  stamps.first = std::min(stamps.first, stamp);
  stamps.last = std::max(stamps.last, stamp);
  stamps.least_delay_s = std::min(stamps.least_delay_s, delay_s);
  stamps.greatest_delay_s = std::max(stamps.greatest_delay_s, delay_s);
  stamps.previous = stamp;
}

/// Of a message of a known type; TF has a stamp for each transform instead.
void TakeHeaderStamp(const Message& message, BagTopic& topic) {
  const std::string& type = message.connection.type;
  if (type == rosbag::kTf2.name || type == rosbag::kTf.name) return;
  const absl::StatusOr<rosbag::Header> header = rosbag::ParseMessageHeader(message.data);
  if (header.ok()) TakeStamp(header->stamp, message.record_time, topic.stamps);
}

void TakeMessage(const Message& message, std::map<std::string, BagTopic>& topics,
                 BagOverview& overview) {
  BagTopic& topic = topics[message.connection.topic];
  if (topic.message_count++ == 0) {
    topic.connection = message.connection;
    topic.first_record = message.record_time;
    topic.fault = std::string(rosbag::CheckType(message.connection).message());
  } else if (topic.connection.type != message.connection.type) {
    topic.fault = "has messages of two types";
  }
  topic.first_record = std::min(topic.first_record, message.record_time);
  topic.last_record = std::max(topic.last_record, message.record_time);
  if (!topic.fault.empty()) return;
  TakeHeaderStamp(message, topic);
  topic.fault = std::string(LookAt(message, topic, overview).message());
}

/// The first of `names`, which are in lower case, that is a field; its spelling in the bag.
std::string SpellingOf(const BagTopic& topic, std::span<const char* const> names) {
  for (const char* const name : names) {
    for (const std::string& field : topic.fields) {
      if (absl::AsciiStrToLower(field) == name) return field;
    }
  }
  return "";
}

/// "front" of "/radar/front/points"; what tells topics of radars apart.
std::string IdOf(const std::string& topic, const BagMapping& mapping) {
  static constexpr std::array kCommon = {"points",     "radar",       "targets",    "scan",
                                         "pointcloud", "point_cloud", "detections", "pcl",
                                         "data",       "cloud"};
  std::string id;
  for (const absl::string_view part : absl::StrSplit(topic, '/', absl::SkipEmpty())) {
    if (std::ranges::find(kCommon, part) == kCommon.end()) id = std::string(part);
  }
  const bool is_taken = std::ranges::any_of(
      mapping.radars, [&](const RadarMapping& radar) { return radar.id == id; });
  return id.empty() || is_taken ? topic : id;
}

// Names of fields as the drivers of radars write them: ours, ti_mmwave_rospkg, Oculii Eagle,
// ARS548, smartmicro, RadarScan converters.
constexpr std::array kRangeRates = {"range_rate",
                                    "doppler",
                                    "radial_speed",
                                    "radial_velocity",
                                    "doppler_velocity",
                                    "velocity_radial",
                                    "velocityradial",
                                    "range_velocity",
                                    "v_doppler_mps",
                                    "v_r",
                                    "vr",
                                    "vrel",
                                    "velocity",
                                    "speed",
                                    "v"};
constexpr std::array kRanges = {"range", "distance"};
constexpr std::array kAzimuths = {"azimuth", "azimuth_angle"};
constexpr std::array kElevations = {"elevation", "elevation_angle"};
constexpr std::array kCrossSections = {"rcs", "rcs_dbsm"};
constexpr std::array kX = {"x"};
constexpr std::array kY = {"y"};
constexpr std::array kZ = {"z"};

void ProposeRadar(const BagTopic& topic, BagMapping& mapping) {
  RadarMapping radar{.id = IdOf(topic.connection.topic, mapping),
                     .topic = topic.connection.topic,
                     .range_rate = SpellingOf(topic, kRangeRates),
                     .rcs = SpellingOf(topic, kCrossSections)};
  radar.range = SpellingOf(topic, kRanges);
  radar.azimuth = SpellingOf(topic, kAzimuths);
  if (radar.range.empty() || radar.azimuth.empty()) {
    radar.range.clear();
    radar.azimuth.clear();
    radar.x = SpellingOf(topic, kX);
    radar.y = SpellingOf(topic, kY);
    if (topic.has_height) radar.z = SpellingOf(topic, kZ);
  } else {
    radar.elevation = SpellingOf(topic, kElevations);
  }
  const BagMapping alone{.radars = {radar}};
  if (Validate(alone).ok()) mapping.radars.push_back(std::move(radar));
}

/// How well a topic tells the vehicle's velocity: 0 not at all.
int MotionRank(const BagTopic& topic) {
  const std::string& type = topic.connection.type;
  if (type == rosbag::kTwistWithCovarianceStamped.name) return 3;
  if (type == rosbag::kOdometry.name) return 2;
  return type == rosbag::kTwistStamped.name ? 1 : 0;
}

}  // namespace

const BagTopic* BagOverview::Find(const std::string& topic) const {
  const auto found = std::ranges::find_if(
      topics, [&](const BagTopic& entry) { return entry.connection.topic == topic; });
  return found == topics.end() ? nullptr : &*found;
}

absl::StatusOr<BagOverview> ReadBagOverview(const std::filesystem::path& path) {
  BagOverview overview;
  std::map<std::string, BagTopic> topics;
  auto summary = rosbag::ReadBag(path, [&](const Message& message) {
    TakeMessage(message, topics, overview);
    return absl::OkStatus();
  });
  if (!summary.ok()) return summary.status();
  overview.summary = *std::move(summary);
  for (auto& [name, topic] : topics) overview.topics.push_back(std::move(topic));
  return overview;
}

BagMapping ProposeMapping(const BagOverview& overview) {
  BagMapping mapping;
  int best_rank = 0;
  for (const BagTopic& topic : overview.topics) {
    if (!topic.fault.empty()) continue;
    if (rosbag::IsPointCloud(topic.connection.type)) ProposeRadar(topic, mapping);
    if (const int rank = MotionRank(topic); rank > best_rank) {
      best_rank = rank;
      mapping.motion_topic = topic.connection.topic;
      const bool is_odometry = !topic.child_frame.empty();
      const std::string& frame = is_odometry ? topic.child_frame : topic.frame;
      if (!frame.empty()) mapping.vehicle_frame = frame;
    }
  }
  return mapping;
}

}  // namespace dcloc
