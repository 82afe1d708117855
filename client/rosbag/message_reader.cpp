#include "client/rosbag/message_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "client/rosbag/bag_bytes.h"
#include "client/rosbag/message_types.h"

namespace dcloc::rosbag {
namespace {

constexpr double kMaxQuaternionError = 1e-3;

Header TakeHeader(ByteReader& reader) {
  reader.Take<std::uint32_t>();  // seq
  const Stamp stamp = reader.TakeTime();
  return {stamp, std::string(absl::StripPrefix(reader.TakeText(), "/"))};
}

Eigen::Vector3d TakeVector(ByteReader& reader) {
  const auto x = reader.Take<double>();
  const auto y = reader.Take<double>();
  return {x, y, reader.Take<double>()};
}

Pose3 TakePose(ByteReader& reader) {
  const Eigen::Vector3d translation_m = TakeVector(reader);
  const Eigen::Vector3d xyz = TakeVector(reader);
  return {translation_m, Eigen::Quaterniond(reader.Take<double>(), xyz.x(), xyz.y(), xyz.z())};
}

/// 36 numbers, row by row; zeros alone mean that nothing is known.
std::optional<Matrix6d> TakeCovariance(ByteReader& reader) {
  Matrix6d covariance;
  for (Eigen::Index row = 0; row < 6; ++row) {
    for (Eigen::Index column = 0; column < 6; ++column) {
      covariance(row, column) = reader.Take<double>();
    }
  }
  if ((covariance.array() == 0.0).all()) return std::nullopt;
  return covariance;
}

absl::Status Whole(const ByteReader& reader) {
  return reader.ok() ? absl::OkStatus() : absl::DataLossError("a message is shorter than its type");
}

std::size_t SizeOf(std::uint8_t datatype) {
  constexpr std::array<std::size_t, 9> kSizes = {0, 1, 1, 2, 2, 4, 4, 4, 8};
  return datatype < kSizes.size() ? kSizes[datatype] : 0;
}

absl::Status CheckFields(const PointCloud& cloud) {
  for (const PointField& field : cloud.fields) {
    const std::size_t size = SizeOf(field.datatype);
    if (size == 0) {
      return absl::DataLossError(
          absl::StrCat("field ", field.name, " is of unknown datatype ", int{field.datatype}));
    }
    if (field.offset + size > cloud.point_bytes) {
      return absl::DataLossError(absl::StrCat("field ", field.name, " ends at byte ",
                                              field.offset + size, " of a point of ",
                                              cloud.point_bytes));
    }
  }
  return absl::OkStatus();
}

/// The rows of a cloud, without what pads them.
absl::Status JoinRows(absl::string_view bytes, std::size_t height, std::size_t width,
                      std::size_t row_bytes, PointCloud& cloud) {
  constexpr std::size_t kMaxPoints = 10'000'000;
  if (height > kMaxPoints || width > kMaxPoints || height * width > kMaxPoints) {
    return absl::DataLossError(absl::StrCat("a point cloud has ", height, " rows of ", width,
                                            " points; at most ", kMaxPoints, " are read"));
  }
  cloud.point_count = height * width;
  const std::size_t used_bytes = width * cloud.point_bytes;
  const std::size_t needed = cloud.point_count == 0 ? 0 : (height - 1) * row_bytes + used_bytes;
  if ((height > 1 && row_bytes < used_bytes) || bytes.size() < needed) {
    return absl::DataLossError(absl::StrCat("a point cloud of ", height, " x ", width,
                                            " points of ", cloud.point_bytes, " bytes has ",
                                            bytes.size(), " bytes of data"));
  }
  for (std::size_t row = 0; row < height && used_bytes > 0; ++row) {
    absl::StrAppend(&cloud.data, bytes.substr(row * row_bytes, used_bytes));
  }
  return absl::OkStatus();
}

template <typename Number>
double NumberAt(const std::string& data, std::size_t offset) {
  Number value{};
  std::memcpy(&value, data.data() + offset, sizeof(Number));
  return static_cast<double>(value);
}

}  // namespace

const PointField* PointCloud::Find(const std::string& name) const {
  const auto found = std::ranges::find(fields, name, &PointField::name);
  return found == fields.end() ? nullptr : &*found;
}

double PointCloud::Value(const PointField& field, std::size_t point) const {
  const std::size_t offset = point * point_bytes + field.offset;
  switch (field.datatype) {
    case 1:
      return NumberAt<std::int8_t>(data, offset);
    case 2:
      return NumberAt<std::uint8_t>(data, offset);
    case 3:
      return NumberAt<std::int16_t>(data, offset);
    case 4:
      return NumberAt<std::uint16_t>(data, offset);
    case 5:
      return NumberAt<std::int32_t>(data, offset);
    case 6:
      return NumberAt<std::uint32_t>(data, offset);
    case 7:
      return NumberAt<float>(data, offset);
    case 8:
      return NumberAt<double>(data, offset);
    default:
      return std::numeric_limits<double>::quiet_NaN();
  }
}

absl::Status CheckType(const Connection& connection) {
  const MessageType* const type = FindType(connection.type);
  if (type == nullptr) {
    return absl::InvalidArgumentError(absl::StrCat("topic ", connection.topic, " is of type ",
                                                   connection.type, ", which is not read"));
  }
  if (connection.md5sum == type->md5sum) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      "topic ", connection.topic, " is of another ", connection.type,
      " than ROS's own: its definition's checksum is ", connection.md5sum, ", not ", type->md5sum));
}

absl::StatusOr<Pose3> CheckedPose(Pose3 pose) {
  const double norm = pose.rotation.norm();
  if (!pose.translation_m.allFinite() || !(std::abs(norm - 1.0) < kMaxQuaternionError)) {
    return absl::DataLossError(
        absl::StrCat("a pose is not finite, or its quaternion's norm is ", norm, " instead of 1"));
  }
  constexpr double kRounding = 1e-12;
  if (std::abs(norm - 1.0) > kRounding) pose.rotation.normalize();
  return pose;
}

absl::StatusOr<Header> ParseMessageHeader(absl::string_view data) {
  ByteReader reader(data);
  Header header = TakeHeader(reader);
  if (absl::Status status = Whole(reader); !status.ok()) return status;
  return header;
}

absl::StatusOr<PointCloud> ParsePointCloud(absl::string_view data) {
  ByteReader reader(data);
  PointCloud cloud{.header = TakeHeader(reader)};
  const auto height = reader.Take<std::uint32_t>();
  const auto width = reader.Take<std::uint32_t>();
  const auto field_count = reader.Take<std::uint32_t>();
  for (std::uint32_t i = 0; i < field_count && reader.ok(); ++i) {
    PointField field{.name = std::string(reader.TakeText())};
    field.offset = reader.Take<std::uint32_t>();
    field.datatype = reader.Take<std::uint8_t>();
    field.count = reader.Take<std::uint32_t>();
    cloud.fields.push_back(std::move(field));
  }
  const bool is_big_endian = reader.Take<std::uint8_t>() != 0;
  cloud.point_bytes = reader.Take<std::uint32_t>();
  const auto row_bytes = reader.Take<std::uint32_t>();
  const absl::string_view bytes = reader.TakeText();
  reader.Take<std::uint8_t>();  // is_dense
  absl::Status status = Whole(reader);
  if (status.ok() && is_big_endian) status = absl::DataLossError("a point cloud is big-endian");
  if (status.ok()) status = CheckFields(cloud);
  if (status.ok()) status = JoinRows(bytes, height, width, row_bytes, cloud);
  if (!status.ok()) return status;
  return cloud;
}

absl::StatusOr<std::vector<Transform>> ParseTransforms(absl::string_view data) {
  ByteReader reader(data);
  std::vector<Transform> transforms;
  const auto count = reader.Take<std::uint32_t>();
  for (std::uint32_t i = 0; i < count && reader.ok(); ++i) {
    const Header header = TakeHeader(reader);
    Transform transform{.stamp = header.stamp, .parent = header.frame_id};
    transform.child = std::string(absl::StripPrefix(reader.TakeText(), "/"));
    const Pose3 pose = TakePose(reader);
    if (!reader.ok()) break;
    absl::StatusOr<Pose3> checked = CheckedPose(pose);
    if (!checked.ok()) {
      return absl::DataLossError(absl::StrCat(transform.parent, " to ", transform.child, ": ",
                                              checked.status().message()));
    }
    transform.T_parent_child = *std::move(checked);
    transforms.push_back(std::move(transform));
  }
  if (absl::Status status = Whole(reader); !status.ok()) return status;
  return transforms;
}

absl::StatusOr<ImuSample> ParseImu(absl::string_view data) {
  ByteReader reader(data);
  ImuSample sample{.header = TakeHeader(reader)};
  constexpr std::size_t kOrientationNumbers = 4 + 9;
  reader.TakeBytes(kOrientationNumbers * sizeof(double));
  sample.angular_radps = TakeVector(reader);
  constexpr std::size_t kRestNumbers = 9 + 3 + 9;
  reader.TakeBytes(kRestNumbers * sizeof(double));
  if (absl::Status status = Whole(reader); !status.ok()) return status;
  return sample;
}

absl::StatusOr<SatelliteFix> ParseSatelliteFix(absl::string_view data) {
  ByteReader reader(data);
  SatelliteFix fix{.header = TakeHeader(reader)};
  fix.has_fix = reader.Take<std::int8_t>() >= 0;
  reader.Take<std::uint16_t>();  // service
  fix.latitude_deg = reader.Take<double>();
  fix.longitude_deg = reader.Take<double>();
  fix.height_m = reader.Take<double>();
  std::array<double, 9> covariance{};
  for (double& value : covariance) value = reader.Take<double>();
  const bool is_known = reader.Take<std::uint8_t>() != 0;
  if (absl::Status status = Whole(reader); !status.ok()) return status;
  if (is_known) {
    fix.horizontal_sigma_m = std::sqrt(std::max(covariance[0], covariance[4]));
    fix.vertical_sigma_m = std::sqrt(covariance[8]);
  }
  return fix;
}

absl::StatusOr<Motion> ParseMotion(absl::string_view type, absl::string_view data) {
  ByteReader reader(data);
  Motion motion{.header = TakeHeader(reader)};
  const bool is_odometry = type == kOdometry.name;
  const bool has_pose =
      is_odometry || type == kPoseStamped.name || type == kPoseWithCovarianceStamped.name;
  const bool has_velocity =
      is_odometry || type == kTwistStamped.name || type == kTwistWithCovarianceStamped.name;
  if (is_odometry) motion.child_frame = std::string(absl::StripPrefix(reader.TakeText(), "/"));
  if (has_pose) motion.T_frame_child = TakePose(reader);
  if (is_odometry || type == kPoseWithCovarianceStamped.name) {
    motion.pose_covariance = TakeCovariance(reader);
  }
  if (has_velocity) {
    EgoVelocity velocity;
    velocity.linear_mps = TakeVector(reader);
    velocity.angular_radps = TakeVector(reader);
    if (type != kTwistStamped.name) velocity.covariance = TakeCovariance(reader);
    motion.velocity = velocity;
  }
  if (absl::Status status = Whole(reader); !status.ok()) return status;
  return motion;
}

}  // namespace dcloc::rosbag
