#include "client/rosbag/message_writer.h"

#include <cstdint>
#include <optional>

#include "client/rosbag/bag_bytes.h"

namespace dcloc::rosbag {
namespace {

void AppendHeader(std::string& bytes, Stamp stamp, const std::string& frame_id) {
  AppendNumber(bytes, std::uint32_t{0});
  AppendTime(bytes, stamp);
  AppendText(bytes, frame_id);
}

void AppendVector(std::string& bytes, const Eigen::Vector3d& vector) {
  for (const double value : vector) AppendNumber(bytes, value);
}

void AppendPose(std::string& bytes, const Pose3& pose) {
  AppendVector(bytes, pose.translation_m);
  AppendVector(bytes, pose.rotation.vec());
  AppendNumber(bytes, pose.rotation.w());
}

void AppendCovariance(std::string& bytes, const std::optional<Matrix6d>& known) {
  const Matrix6d covariance = known.value_or(Matrix6d::Zero());
  for (Eigen::Index row = 0; row < 6; ++row) {
    for (Eigen::Index column = 0; column < 6; ++column) {
      AppendNumber(bytes, covariance(row, column));
    }
  }
}

void AppendVelocity(std::string& bytes, const EgoVelocity& velocity) {
  AppendVector(bytes, velocity.linear_mps);
  AppendVector(bytes, velocity.angular_radps);
  AppendCovariance(bytes, velocity.covariance);
}

}  // namespace

std::string FormatPointCloud(const PointCloud& cloud) {
  std::string bytes;
  AppendHeader(bytes, cloud.header.stamp, cloud.header.frame_id);
  AppendNumber(bytes, std::uint32_t{1});  // height
  AppendNumber(bytes, static_cast<std::uint32_t>(cloud.point_count));
  AppendNumber(bytes, static_cast<std::uint32_t>(cloud.fields.size()));
  for (const PointField& field : cloud.fields) {
    AppendText(bytes, field.name);
    AppendNumber(bytes, field.offset);
    AppendNumber(bytes, field.datatype);
    AppendNumber(bytes, field.count);
  }
  AppendNumber(bytes, std::uint8_t{0});  // little-endian
  AppendNumber(bytes, static_cast<std::uint32_t>(cloud.point_bytes));
  AppendNumber(bytes, static_cast<std::uint32_t>(cloud.point_bytes * cloud.point_count));
  AppendText(bytes, cloud.data);
  AppendNumber(bytes, std::uint8_t{1});  // no point is invalid
  return bytes;
}

std::string FormatTransforms(const std::vector<Transform>& transforms) {
  std::string bytes;
  AppendNumber(bytes, static_cast<std::uint32_t>(transforms.size()));
  for (const Transform& transform : transforms) {
    AppendHeader(bytes, transform.stamp, transform.parent);
    AppendText(bytes, transform.child);
    AppendPose(bytes, transform.T_parent_child);
  }
  return bytes;
}

std::string FormatVelocity(const Header& header, const EgoVelocity& velocity) {
  std::string bytes;
  AppendHeader(bytes, header.stamp, header.frame_id);
  AppendVelocity(bytes, velocity);
  return bytes;
}

std::string FormatPose(const Motion& motion) {
  std::string bytes;
  AppendHeader(bytes, motion.header.stamp, motion.header.frame_id);
  AppendPose(bytes, *motion.T_frame_child);
  AppendCovariance(bytes, motion.pose_covariance);
  return bytes;
}

std::string FormatOdometry(const Motion& motion) {
  std::string bytes;
  AppendHeader(bytes, motion.header.stamp, motion.header.frame_id);
  AppendText(bytes, motion.child_frame);
  AppendPose(bytes, *motion.T_frame_child);
  AppendCovariance(bytes, motion.pose_covariance);
  AppendVelocity(bytes, *motion.velocity);
  return bytes;
}

std::string FormatDiagnostics(Stamp stamp, const std::vector<Diagnostic>& entries) {
  std::string bytes;
  AppendHeader(bytes, stamp, "");
  AppendNumber(bytes, static_cast<std::uint32_t>(entries.size()));
  for (const Diagnostic& entry : entries) {
    AppendNumber(bytes, static_cast<std::int8_t>(entry.level));
    AppendText(bytes, entry.name);
    AppendText(bytes, entry.message);
    AppendText(bytes, "");  // hardware_id
    AppendNumber(bytes, static_cast<std::uint32_t>(entry.values.size()));
    for (const auto& [key, value] : entry.values) {
      AppendText(bytes, key);
      AppendText(bytes, value);
    }
  }
  return bytes;
}

}  // namespace dcloc::rosbag
