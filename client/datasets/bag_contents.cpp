#include "client/datasets/bag_contents.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client/rosbag/message_reader.h"
#include "client/rosbag/message_types.h"
#include "core/geometry/degrees.h"

namespace dcloc {
namespace {

using rosbag::Message;
using rosbag::PointCloud;
using rosbag::PointField;

absl::StatusOr<const PointField*> FieldOf(const PointCloud& cloud, const std::string& name) {
  if (name.empty()) return nullptr;
  if (const PointField* const field = cloud.Find(name); field != nullptr) return field;
  const auto each = [](std::string* out, const PointField& field) { *out += field.name; };
  return absl::InvalidArgumentError(absl::StrCat("has no field \"", name, "\"; its fields are ",
                                                 absl::StrJoin(cloud.fields, ", ", each)));
}

/// The fields of a cloud by what they mean; those that are not there are null.
struct CloudColumns {
  const PointField* first = nullptr;   ///< range, or x
  const PointField* second = nullptr;  ///< azimuth, or y
  const PointField* third = nullptr;   ///< elevation, or z
  const PointField* range_rate = nullptr;
  const PointField* rcs = nullptr;
};

absl::StatusOr<CloudColumns> CloudColumnsOf(const PointCloud& cloud, const RadarMapping& radar) {
  const bool is_polar = radar.IsPolar();
  CloudColumns columns;
  absl::Status status;
  const auto take = [&](const std::string& name, const PointField*& field) {
    const absl::StatusOr<const PointField*> found = FieldOf(cloud, name);
    status.Update(found.status());
    if (found.ok()) field = *found;
  };
  take(is_polar ? radar.range : radar.x, columns.first);
  take(is_polar ? radar.azimuth : radar.y, columns.second);
  take(is_polar ? radar.elevation : radar.z, columns.third);
  take(radar.range_rate, columns.range_rate);
  take(radar.rcs, columns.rcs);
  if (!status.ok()) return status;
  return columns;
}

/// A target in the radar's polar frame.
struct CloudTarget {
  double range_m, azimuth_rad, elevation_rad, range_rate_mps, rcs_dbsm;
};

CloudTarget TargetOf(const PointCloud& cloud, const CloudColumns& columns,
                     const RadarMapping& radar, std::size_t point) {
  const auto value = [&](const PointField* field) {
    return field == nullptr ? 0.0 : cloud.Value(*field, point);
  };
  const double first = value(columns.first);
  const double second = value(columns.second);
  const double third = value(columns.third);
  CloudTarget target{first, second, third, value(columns.range_rate), value(columns.rcs)};
  if (!radar.IsPolar()) {
    target.range_m = std::hypot(first, second, third);
    target.azimuth_rad = std::atan2(second, first);
    target.elevation_rad = std::atan2(third, std::hypot(first, second));
  } else if (radar.angles_in_degrees) {
    target.azimuth_rad *= kRadPerDeg;
    target.elevation_rad *= kRadPerDeg;
  }
  if (radar.azimuth_is_clockwise) target.azimuth_rad = -target.azimuth_rad;
  if (radar.range_rate_is_towards) target.range_rate_mps = -target.range_rate_mps;
  return target;
}

bool IsFinite(const CloudTarget& target) {
  return std::isfinite(target.range_m) && target.range_m > 0.0 &&
         std::isfinite(target.azimuth_rad) && std::isfinite(target.elevation_rad) &&
         std::isfinite(target.range_rate_mps) && std::isfinite(target.rcs_dbsm);
}

absl::StatusOr<Scan> ScanOf(const PointCloud& cloud, const RadarMapping& radar) {
  const absl::StatusOr<CloudColumns> columns = CloudColumnsOf(cloud, radar);
  if (!columns.ok()) return columns.status();
  Scan scan;
  scan.stamp = cloud.header.stamp;
  scan.radar_id = radar.id;
  for (std::size_t i = 0; i < cloud.point_count; ++i) {
    const CloudTarget target = TargetOf(cloud, *columns, radar, i);
    if (!IsFinite(target)) continue;
    scan.range_m.push_back(static_cast<float>(target.range_m));
    scan.azimuth_rad.push_back(static_cast<float>(target.azimuth_rad));
    scan.range_rate_mps.push_back(static_cast<float>(target.range_rate_mps));
    if (radar.HasElevation()) {
      scan.elevation_rad.push_back(static_cast<float>(target.elevation_rad));
    }
    if (columns->rcs != nullptr) scan.rcs_dbsm.push_back(static_cast<float>(target.rcs_dbsm));
  }
  if (absl::Status status = Validate(scan); !status.ok()) {
    return absl::DataLossError(absl::StrCat("the scan at ", scan.stamp.time_since_epoch().count(),
                                            " ns: ", status.message()));
  }
  return scan;
}

absl::Status WrongType(const Message& message, const char* wanted) {
  return absl::InvalidArgumentError(
      absl::StrCat("is of type ", message.connection.type, "; it must be ", wanted));
}

absl::Status TakeMotion(const Message& message, bool is_velocity,
                        std::vector<rosbag::Motion>& motions) {
  const std::string& type = message.connection.type;
  if (type == rosbag::kPointCloud2.name || type == rosbag::kImu.name ||
      type == rosbag::kNavSatFix.name || type == rosbag::kTf.name || type == rosbag::kTf2.name) {
    return WrongType(message, "Odometry, a twist or a pose with a stamp");
  }
  absl::StatusOr<rosbag::Motion> motion = rosbag::ParseMotion(type, message.data);
  if (!motion.ok()) return motion.status();
  if (is_velocity && !motion->velocity) {
    return WrongType(message, "Odometry or a twist with a stamp");
  }
  if (!is_velocity) {
    if (!motion->T_frame_child) return WrongType(message, "Odometry or a pose with a stamp");
    absl::StatusOr<Pose3> checked = rosbag::CheckedPose(*motion->T_frame_child);
    if (!checked.ok()) return checked.status();
    motion->T_frame_child = *std::move(checked);
  }
  motions.push_back(*std::move(motion));
  return absl::OkStatus();
}

template <typename Stamped>
void SortByStamp(std::vector<Stamped>& messages) {
  std::ranges::stable_sort(messages, {},
                           [](const Stamped& message) { return message.header.stamp; });
}

}  // namespace

absl::Status BagCollector::Take(const Message& message) {
  const std::string& topic = message.connection.topic;
  const std::string& type = message.connection.type;
  const bool is_transform = type == rosbag::kTf2.name || type == rosbag::kTf.name;
  const bool is_motion = topic == mapping_.motion_topic;
  const bool is_reference = topic == mapping_.reference_topic;
  const auto radar = std::ranges::find(mapping_.radars, topic, &RadarMapping::topic);
  const bool is_radar = radar != mapping_.radars.end();
  const bool is_imu = topic == mapping_.imu_topic;
  if (!is_transform && !is_motion && !is_reference && !is_radar && !is_imu) {
    return absl::OkStatus();
  }
  seen_.insert(topic);
  absl::Status status = rosbag::CheckType(message.connection);
  if (!status.ok()) return status;
  if (is_radar) status.Update(TakeScan(*radar, message));
  if (is_transform) status.Update(TakeTransforms(message));
  if (is_motion) status.Update(TakeMotion(message, /*is_velocity=*/true, contents_.motions));
  if (is_reference) {
    status.Update(TakeMotion(message, /*is_velocity=*/false, contents_.references));
  }
  if (is_imu) status.Update(TakeTurnRate(message));
  if (status.ok()) return status;
  return absl::Status(status.code(), absl::StrCat("topic ", topic, ": ", status.message()));
}

absl::Status BagCollector::CheckSeen() const {
  std::vector<std::string> wanted = {mapping_.motion_topic, mapping_.imu_topic,
                                     mapping_.reference_topic};
  for (const RadarMapping& radar : mapping_.radars) wanted.push_back(radar.topic);
  for (const std::string& topic : wanted) {
    if (topic.empty() || seen_.contains(topic)) continue;
    return absl::NotFoundError(absl::StrCat("has no messages of topic ", topic));
  }
  return absl::OkStatus();
}

absl::Status BagCollector::TakeScan(const RadarMapping& radar, const Message& message) {
  if (message.connection.type != rosbag::kPointCloud2.name) {
    return WrongType(message, rosbag::kPointCloud2.name);
  }
  const absl::StatusOr<PointCloud> cloud = rosbag::ParsePointCloud(message.data);
  if (!cloud.ok()) return cloud.status();
  absl::StatusOr<Scan> scan = ScanOf(*cloud, radar);
  if (!scan.ok()) return scan.status();
  contents_.frames[radar.id] = cloud->header.frame_id;
  contents_.scans.push_back(*std::move(scan));
  return absl::OkStatus();
}

absl::Status BagCollector::TakeTransforms(const Message& message) {
  const auto transforms = rosbag::ParseTransforms(message.data);
  if (!transforms.ok()) return transforms.status();
  const bool is_static = message.connection.topic == "/tf_static";
  for (const rosbag::Transform& transform : *transforms) {
    contents_.transforms.Add(transform, is_static);
  }
  return absl::OkStatus();
}

absl::Status BagCollector::TakeTurnRate(const Message& message) {
  if (message.connection.type != rosbag::kImu.name) return WrongType(message, rosbag::kImu.name);
  absl::StatusOr<rosbag::ImuSample> sample = rosbag::ParseImu(message.data);
  if (!sample.ok()) return sample.status();
  contents_.turn_rates.push_back(*std::move(sample));
  return absl::OkStatus();
}

void SortByStamp(BagContents& contents) {
  contents.transforms.Sort();
  SortByStamp(contents.motions);
  SortByStamp(contents.turn_rates);
  SortByStamp(contents.references);
}

absl::StatusOr<BagContents> ReadBagContents(const std::filesystem::path& path,
                                            const BagMapping& mapping) {
  BagContents contents;
  BagCollector collector(mapping, contents);
  auto summary =
      rosbag::ReadBag(path, [&](const Message& message) { return collector.Take(message); });
  if (!summary.ok()) return summary.status();
  if (absl::Status status = collector.CheckSeen(); !status.ok()) {
    return absl::NotFoundError(absl::StrCat(path.string(), ": ", status.message()));
  }
  contents.summary = *std::move(summary);
  SortByStamp(contents);
  return contents;
}

}  // namespace dcloc
