#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client/rosbag/bag_reader.h"
#include "client/rosbag/messages.h"

namespace dcloc::rosbag {

/// InvalidArgument, naming topic and type, unless the message's type is one of KnownTypes by name
/// and checksum.
absl::Status CheckType(const Connection& connection);

/// A pose with a rotation; one whose quaternion's norm is 1 but for rounding stays as it is, to the
/// bit. DataLoss where it is not finite, or its quaternion is none.
absl::StatusOr<Pose3> CheckedPose(Pose3 pose);

// Each parses a message's data. DataLoss where it is shorter than its type, or holds what its type
// does not allow; the message's topic is not named.

/// Of any type that begins with a header: all known ones but TF's.
absl::StatusOr<Header> ParseMessageHeader(absl::string_view data);
absl::StatusOr<PointCloud> ParsePointCloud(absl::string_view data);
absl::StatusOr<std::vector<Transform>> ParseTransforms(absl::string_view data);
absl::StatusOr<ImuSample> ParseImu(absl::string_view data);
absl::StatusOr<SatelliteFix> ParseSatelliteFix(absl::string_view data);

/// Of kPointCloud, as a cloud of floats whose fields are x, y, z and the channels.
absl::StatusOr<PointCloud> ParseChannelCloud(absl::string_view data);

/// Of `type`, one of the two types of point clouds.
absl::StatusOr<PointCloud> ParseCloudOf(absl::string_view type, absl::string_view data);

/// Of `type`, one of kOdometry, kTwistStamped, kTwistWithCovarianceStamped, kPoseStamped and
/// kPoseWithCovarianceStamped. The pose is not checked: publishers of velocities leave it zero.
absl::StatusOr<Motion> ParseMotion(absl::string_view type, absl::string_view data);

}  // namespace dcloc::rosbag
