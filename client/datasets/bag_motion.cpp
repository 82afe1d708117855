#include "client/datasets/bag_motion.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/rosbag/message_reader.h"

namespace dcloc {
namespace {

constexpr std::chrono::nanoseconds kMaxVelocityAge = std::chrono::milliseconds(100);

/// Where a frame sits on the vehicle; an empty one is the vehicle's.
absl::StatusOr<Pose3> MountOf(const std::string& frame, const BagContents& contents,
                              const BagMapping& mapping, const std::string& topic) {
  if (frame.empty() || frame == mapping.vehicle_frame) return Pose3();
  const std::optional<Pose3> mount = contents.transforms.Static(mapping.vehicle_frame, frame);
  if (mount) return *mount;
  return absl::InvalidArgumentError(absl::StrCat("topic ", topic, " is of frame ", frame,
                                                 ", and TF does not say where it sits on ",
                                                 mapping.vehicle_frame));
}

/// The velocity of the vehicle's origin from that of a point of it, both in their own frames.
EgoVelocity OfVehicle(const EgoVelocity& velocity, const Pose3& T_vehicle_frame) {
  const Eigen::Matrix3d R = T_vehicle_frame.Rotation();
  EgoVelocity result;
  result.angular_radps = R * velocity.angular_radps;
  result.linear_mps =
      R * velocity.linear_mps - result.angular_radps.cross(T_vehicle_frame.translation_m);
  if (!velocity.covariance) return result;
  Matrix6d jacobian = Matrix6d::Zero();
  jacobian.topLeftCorner<3, 3>() = R;
  jacobian.topRightCorner<3, 3>() = Skew(T_vehicle_frame.translation_m) * R;
  jacobian.bottomRightCorner<3, 3>() = R;
  result.covariance = jacobian * *velocity.covariance * jacobian.transpose();
  return result;
}

EgoVelocity Between(const EgoVelocity& a, const EgoVelocity& b, double share) {
  EgoVelocity result{a.linear_mps + share * (b.linear_mps - a.linear_mps),
                     a.angular_radps + share * (b.angular_radps - a.angular_radps), std::nullopt};
  if (a.covariance && b.covariance) {
    result.covariance = *a.covariance + share * (*b.covariance - *a.covariance);
  }
  return result;
}

template <typename Samples>
std::optional<EgoVelocity> At(const Samples& samples, Stamp stamp) {
  const auto after =
      std::ranges::lower_bound(samples, stamp, {}, [](const auto& sample) { return sample.stamp; });
  const bool has_after = after != samples.end() && after->stamp - stamp <= kMaxVelocityAge;
  const bool has_before =
      after != samples.begin() && stamp - std::prev(after)->stamp <= kMaxVelocityAge;
  if (has_after && (after->stamp == stamp || !has_before)) return after->velocity;
  if (!has_before) return std::nullopt;
  const auto before = std::prev(after);
  if (!has_after) return before->velocity;
  return Between(before->velocity, after->velocity,
                 static_cast<double>((stamp - before->stamp).count()) /
                     static_cast<double>((after->stamp - before->stamp).count()));
}

}  // namespace

absl::StatusOr<BagMotion> BagMotion::Create(const BagContents& contents,
                                            const BagMapping& mapping) {
  BagMotion motion;
  absl::Status status = motion.TakeVelocities(contents, mapping);
  status.Update(motion.TakeTurnRates(contents, mapping));
  status.Update(motion.TakePoses(contents, mapping));
  if (!status.ok()) return status;
  return motion;
}

absl::Status BagMotion::TakeVelocities(const BagContents& contents, const BagMapping& mapping) {
  for (const rosbag::Motion& motion : contents.motions) {
    // Of Odometry the child's frame counts, of a twist the header's.
    const std::string& frame = motion.T_frame_child ? motion.child_frame : motion.header.frame_id;
    const auto mount = MountOf(frame, contents, mapping, mapping.motion_topic);
    if (!mount.ok()) return mount.status();
    const bool is_vehicle = frame.empty() || frame == mapping.vehicle_frame;
    velocities_.push_back(
        {motion.header.stamp, is_vehicle ? *motion.velocity : OfVehicle(*motion.velocity, *mount)});
  }
  return absl::OkStatus();
}

absl::Status BagMotion::TakeTurnRates(const BagContents& contents, const BagMapping& mapping) {
  for (const rosbag::ImuSample& sample : contents.turn_rates) {
    const auto mount = mapping.T_vehicle_imu
                           ? *mapping.T_vehicle_imu
                           : MountOf(sample.header.frame_id, contents, mapping, mapping.imu_topic);
    if (!mount.ok()) return mount.status();
    turn_rates_.push_back(
        {sample.header.stamp,
         {Eigen::Vector3d::Zero(), mount->Rotation() * sample.angular_radps, std::nullopt}});
  }
  return absl::OkStatus();
}

absl::Status BagMotion::TakePoses(const BagContents& contents, const BagMapping& mapping) {
  const bool has_topic = !contents.references.empty();
  const bool has_tf =
      !has_topic && !contents.scans.empty() &&
      std::ranges::any_of(contents.scans, [&](const Scan& scan) {
        return contents.transforms.At(mapping.map_frame, mapping.vehicle_frame, scan.stamp)
            .has_value();
      });
  pose_parent_ = mapping.map_frame;
  pose_child_ = mapping.vehicle_frame;
  if (has_tf) {
    poses_ = contents.transforms;
    pose_source_ = PoseSource::kReference;
    return absl::OkStatus();
  }
  const std::vector<rosbag::Motion>& motions = has_topic ? contents.references : contents.motions;
  for (const rosbag::Motion& motion : motions) {
    if (!motion.T_frame_child) return absl::OkStatus();
    const absl::StatusOr<Pose3> pose = rosbag::CheckedPose(*motion.T_frame_child);
    if (!pose.ok()) return absl::OkStatus();  // of odometry that counts no poses
    const std::string& topic = has_topic ? mapping.reference_topic : mapping.motion_topic;
    const bool is_placed = has_topic && mapping.T_vehicle_reference.has_value();
    const auto mount = is_placed ? *mapping.T_vehicle_reference
                                 : MountOf(motion.child_frame, contents, mapping, topic);
    if (!mount.ok()) return mount.status();
    const bool is_vehicle =
        !is_placed && (motion.child_frame.empty() || motion.child_frame == mapping.vehicle_frame);
    poses_.Add({motion.header.stamp, pose_parent_, pose_child_,
                is_vehicle ? *pose : *pose * mount->Inverse()},
               /*is_static=*/false);
  }
  poses_.Sort();
  if (!motions.empty()) pose_source_ = has_topic ? PoseSource::kReference : PoseSource::kOdometry;
  return absl::OkStatus();
}

std::optional<EgoVelocity> BagMotion::VelocityAt(Stamp stamp) const {
  std::optional<EgoVelocity> velocity = At(velocities_, stamp);
  if (!velocity || turn_rates_.empty()) return velocity;
  if (const std::optional<EgoVelocity> turn = At(turn_rates_, stamp)) {
    velocity->angular_radps = turn->angular_radps;
  }
  return velocity;
}

std::optional<Eigen::Vector3d> BagMotion::TurnRateAt(Stamp stamp) const {
  const std::optional<EgoVelocity> turn = At(turn_rates_, stamp);
  if (!turn) return std::nullopt;
  return turn->angular_radps;
}

std::optional<Pose3> BagMotion::PoseAt(Stamp stamp) const {
  if (pose_source_ == PoseSource::kNone) return std::nullopt;
  return poses_.At(pose_parent_, pose_child_, stamp);
}

}  // namespace dcloc
