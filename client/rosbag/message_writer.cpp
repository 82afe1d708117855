#include "client/rosbag/message_writer.h"

#include <cstdint>

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
  AppendVector(bytes, velocity.linear_mps);
  AppendVector(bytes, velocity.angular_radps);
  const Matrix6d covariance = velocity.covariance.value_or(Matrix6d::Zero());
  for (Eigen::Index row = 0; row < 6; ++row) {
    for (Eigen::Index column = 0; column < 6; ++column) {
      AppendNumber(bytes, covariance(row, column));
    }
  }
  return bytes;
}

}  // namespace dcloc::rosbag
