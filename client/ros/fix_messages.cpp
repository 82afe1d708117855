#include "client/ros/fix_messages.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "client/rosbag/message_reader.h"

namespace dcloc::node {
namespace {

constexpr double kMinVariance_m2 = 0.01;
constexpr double kMinVariance_rad2 = 1e-4;
/// Of a pose without a covariance, as RViz's button means it.
constexpr double kUsualVariance_m2 = 0.25;
constexpr double kUsualVariance_rad2 = 0.0685;

Matrix6d Widened(const rosbag::Motion& message) {
  Matrix6d covariance = Matrix6d::Zero();
  if (message.pose_covariance) {
    covariance = *message.pose_covariance;
  } else {
    covariance.diagonal().head<3>().setConstant(kUsualVariance_m2);
    covariance.diagonal().tail<3>().setConstant(kUsualVariance_rad2);
  }
  for (Eigen::Index i = 0; i < 6; ++i) {
    covariance(i, i) = std::max(covariance(i, i), i < 3 ? kMinVariance_m2 : kMinVariance_rad2);
  }
  return covariance;
}

}  // namespace

absl::StatusOr<v1::PositionFix> FixOf(const rosbag::SatelliteFix& message, double sigma_m) {
  if (!message.has_fix) return absl::FailedPreconditionError("the receiver has no fix");
  v1::PositionFix fix;
  fix.set_stamp_ns(message.header.stamp.time_since_epoch().count());
  v1::GnssFix& gnss = *fix.mutable_gnss_fix();
  gnss.mutable_position()->set_latitude_deg(message.latitude_deg);
  gnss.mutable_position()->set_longitude_deg(message.longitude_deg);
  gnss.mutable_position()->set_height_m(message.height_m);
  gnss.set_horizontal_sigma_m(message.horizontal_sigma_m.value_or(sigma_m));
  gnss.set_vertical_sigma_m(message.vertical_sigma_m.value_or(2.0 * sigma_m));
  return fix;
}

absl::StatusOr<v1::PoseWithCovariance> PoseOf(const rosbag::Motion& message,
                                              const std::string& map_frame) {
  const std::string& frame = message.header.frame_id;
  if (!frame.empty() && frame != map_frame) {
    return absl::InvalidArgumentError(
        absl::StrCat("its frame is ", frame, "; it must be ", map_frame));
  }
  const absl::StatusOr<Pose3> pose = rosbag::CheckedPose(message.T_frame_child.value_or(Pose3()));
  if (!pose.ok()) return pose.status();
  v1::PoseWithCovariance result;
  v1::Vector3& t = *result.mutable_pose()->mutable_translation_m();
  t.set_x(pose->translation_m.x());
  t.set_y(pose->translation_m.y());
  t.set_z(pose->translation_m.z());
  v1::Quaternion& q = *result.mutable_pose()->mutable_rotation();
  q.set_w(pose->rotation.w());
  q.set_x(pose->rotation.x());
  q.set_y(pose->rotation.y());
  q.set_z(pose->rotation.z());
  const Matrix6d covariance = Widened(message);
  for (Eigen::Index i = 0; i < 6; ++i) {
    for (Eigen::Index j = 0; j < 6; ++j) result.add_covariance(covariance(i, j));
  }
  return result;
}

}  // namespace dcloc::node
