#pragma once

#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "client/datasets/bag_contents.h"
#include "client/datasets/bag_mapping.h"
#include "client/datasets/drive.h"
#include "core/radar/ego_velocity.h"
#include "core/radar/stamp.h"

namespace dcloc {

/// The vehicle's motion over time, from the topics of a bag.
class BagMotion {
 public:
  /// InvalidArgument where a frame of a velocity is not the vehicle's and TF does not tell where it
  /// sits on it, or a velocity is not finite.
  static absl::StatusOr<BagMotion> Create(const BagContents& contents, const BagMapping& mapping);

  /// Linear between the samples around `stamp`, one at the very stamp as it is; absent where the
  /// nearest is more than 0.1 s away.
  std::optional<EgoVelocity> VelocityAt(Stamp stamp) const;

  /// The turn rate [rad/s] in the vehicle frame by `imu_topic`, between samples likewise.
  std::optional<Eigen::Vector3d> TurnRateAt(Stamp stamp) const;

  /// By the reference topic or TF, else the odometry's own.
  std::optional<Pose3> PoseAt(Stamp stamp) const;

  /// What the poses of `PoseAt` are.
  PoseSource pose_source() const { return pose_source_; }

 private:
  struct Sample {
    Stamp stamp;
    EgoVelocity velocity;
  };

  absl::Status TakeVelocities(const BagContents& contents, const BagMapping& mapping);
  absl::Status TakeTurnRates(const BagContents& contents, const BagMapping& mapping);
  absl::Status TakePoses(const BagContents& contents, const BagMapping& mapping);

  std::vector<Sample> velocities_;
  std::vector<Sample> turn_rates_;
  rosbag::TransformTree poses_;
  std::string pose_parent_;
  std::string pose_child_;
  PoseSource pose_source_ = PoseSource::kNone;
};

}  // namespace dcloc
