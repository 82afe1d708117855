#include "server/convert/geometry.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "core/geometry/covariance.h"
#include "core/geometry/geodetic_heading.h"
#include "server/base/check.h"
#include "server/base/status.h"

namespace dcloc::server::convert {
namespace {

constexpr double kMaxCovariance = 1e12;
constexpr double kQuaternionNormTolerance = 1e-3;
constexpr int kDof = Pose3::kDof;

using RowMajor6d = Eigen::Matrix<double, kDof, kDof, Eigen::RowMajor>;

absl::Status CheckTranslation(const Eigen::Vector3d& translation_m, absl::string_view field) {
  constexpr const char* kAxes[] = {"x", "y", "z"};
  for (int axis = 0; axis < 3; ++axis) {
    absl::Status status = CheckBetween(absl::StrCat(field, ".", kAxes[axis]), translation_m[axis],
                                       -kMaxWireCoordinate_m, kMaxWireCoordinate_m);
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

}  // namespace

Eigen::Vector3d VectorFromProto(const v1::Vector3& message) {
  return {message.x(), message.y(), message.z()};
}

absl::StatusOr<Pose3> FromProto(const v1::Pose& message, absl::string_view field) {
  if (!message.has_translation_m()) return Missing(absl::StrCat(field, ".translation_m"));
  if (!message.has_rotation()) return Missing(absl::StrCat(field, ".rotation"));
  Pose3 pose;
  pose.translation_m = VectorFromProto(message.translation_m());
  const v1::Quaternion& q = message.rotation();
  pose.rotation = Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z());
  absl::Status status = CheckTranslation(pose.translation_m, absl::StrCat(field, ".translation_m"));
  status.Update(CheckBetween(absl::StrCat("the norm of ", field, ".rotation"), pose.rotation.norm(),
                             1.0 - kQuaternionNormTolerance, 1.0 + kQuaternionNormTolerance));
  if (!status.ok()) return status;
  pose.rotation.normalize();
  return pose;
}

absl::StatusOr<Matrix6d> CovarianceFromProto(const google::protobuf::RepeatedField<double>& values,
                                             absl::string_view field) {
  if (values.size() != kDof * kDof) {
    return absl::InvalidArgumentError(
        absl::StrFormat("%s has %d values; it must have %d", field, values.size(), kDof * kDof));
  }
  for (int i = 0; i < values.size(); ++i) {
    absl::Status status =
        CheckBetween(absl::StrCat(field, "[", i, "]"), values[i], -kMaxCovariance, kMaxCovariance);
    if (!status.ok()) return status;
  }
  const Matrix6d covariance = Eigen::Map<const RowMajor6d>(values.data());
  if (IsCovariance(covariance)) return covariance;
  return absl::InvalidArgumentError(
      absl::StrCat(field, " must be symmetric and positive semidefinite"));
}

absl::StatusOr<GeodeticPosition> FromProto(const v1::GeodeticPosition& message,
                                           absl::string_view field) {
  const GeodeticPosition position{.latitude_deg = message.latitude_deg(),
                                  .longitude_deg = message.longitude_deg(),
                                  .height_m = message.height_m()};
  absl::Status status = WithPrefix(absl::StrCat(field, ": "), Validate(position));
  if (!status.ok()) return status;
  return position;
}

void ToProto(const Eigen::Vector3d& vector, v1::Vector3* message) {
  message->set_x(vector.x());
  message->set_y(vector.y());
  message->set_z(vector.z());
}

void ToProto(const Pose3& pose, v1::Pose* message) {
  ToProto(pose.translation_m, message->mutable_translation_m());
  v1::Quaternion* rotation = message->mutable_rotation();
  rotation->set_w(pose.rotation.w());
  rotation->set_x(pose.rotation.x());
  rotation->set_y(pose.rotation.y());
  rotation->set_z(pose.rotation.z());
}

void ToProto(const GeodeticPosition& position, v1::GeodeticPosition* message) {
  message->set_latitude_deg(position.latitude_deg);
  message->set_longitude_deg(position.longitude_deg);
  message->set_height_m(position.height_m);
}

void ToProto(const GeodeticAnchor& anchor, v1::GeodeticAnchor* message) {
  ToProto(anchor.origin, message->mutable_origin());
  message->set_x_axis_east_rad(anchor.x_axis_east_rad);
}

void ToProto(const Pose3& T_map_vehicle, const Matrix6d& covariance,
             v1::PoseWithCovariance* message) {
  ToProto(T_map_vehicle, message->mutable_pose());
  message->mutable_covariance()->Resize(kDof * kDof, 0.0);
  Eigen::Map<RowMajor6d>(message->mutable_covariance()->mutable_data()) =
      FixedAxesFromTangent(T_map_vehicle, covariance);
}

void ToProto(const GeodeticAnchor& anchor, const Pose3& T_map_vehicle, v1::GeodeticPose* message) {
  const GeodeticPosition position = GeodeticFromMap(anchor, T_map_vehicle.translation_m);
  ToProto(position, message->mutable_position());
  message->set_heading_deg(HeadingFromMap(anchor, T_map_vehicle));
}

}  // namespace dcloc::server::convert
