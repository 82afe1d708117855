#pragma once

#include "absl/strings/string_view.h"

#include "absl/status/statusor.h"
#include "core/geometry/geodetic_anchor.h"
#include "core/geometry/pose.h"
#include "dcloc/v1/geometry.pb.h"

/// Conversions between messages and core's types. `FromProto` accepts anything that a peer may
/// send, and returns a valid core value or InvalidArgument that names the field, the value and the
/// bound; `field` is the path of the message for that. `ToProto` cannot fail.
namespace dcloc::server::convert {

/// Of positions on the wire, along each axis: within 1e5 km of their parent's origin.
inline constexpr double kMaxWireCoordinate_m = 1e8;

/// Finite, within 1e5 km of its parent's origin; the rotation's norm within 1e-3 of 1, then made 1.
absl::StatusOr<Pose3> FromProto(const v1::Pose& message, absl::string_view field);

/// The 36 values as a matrix, symmetric and positive semidefinite, no value above 1e12.
absl::StatusOr<Matrix6d> CovarianceFromProto(const google::protobuf::RepeatedField<double>& values,
                                             absl::string_view field);

absl::StatusOr<GeodeticPosition> FromProto(const v1::GeodeticPosition& message,
                                           absl::string_view field);

Eigen::Vector3d VectorFromProto(const v1::Vector3& message);

void ToProto(const Eigen::Vector3d& vector, v1::Vector3* message);
void ToProto(const Pose3& pose, v1::Pose* message);
void ToProto(const GeodeticPosition& position, v1::GeodeticPosition* message);
void ToProto(const GeodeticAnchor& anchor, v1::GeodeticAnchor* message);

/// `covariance` in the tangent space on the right of `T_map_vehicle`; on the wire about fixed axes.
void ToProto(const Pose3& T_map_vehicle, const Matrix6d& covariance,
             v1::PoseWithCovariance* message);

/// Position and heading on the Earth of a vehicle at `T_map_vehicle`.
void ToProto(const GeodeticAnchor& anchor, const Pose3& T_map_vehicle, v1::GeodeticPose* message);

}  // namespace dcloc::server::convert
