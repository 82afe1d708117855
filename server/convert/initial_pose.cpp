#include "server/convert/initial_pose.h"

#include "absl/strings/str_cat.h"
#include "core/geometry/covariance.h"
#include "core/relocalization/gnss_prior.h"
#include "server/base/check.h"
#include "server/convert/geometry.h"

namespace dcloc::server::convert {
namespace {

constexpr double kMaxGnssSigma_m = 1e4;
constexpr double kMinGnssSigma_m = 1e-3;
constexpr double kMinHeadingSigma_deg = 1e-3;

absl::Status Check(const v1::GnssFix& message, absl::string_view field) {
  absl::Status status =
      CheckBetween(absl::StrCat(field, ".horizontal_sigma_m"), message.horizontal_sigma_m(),
                   kMinGnssSigma_m, kMaxGnssSigma_m);
  status.Update(CheckBetween(absl::StrCat(field, ".vertical_sigma_m"), message.vertical_sigma_m(),
                             kMinGnssSigma_m, kMaxGnssSigma_m));
  if (message.has_heading_deg()) {
    status.Update(
        CheckBetween(absl::StrCat(field, ".heading_deg"), message.heading_deg(), 0.0, 360.0));
    status.Update(CheckBetween(absl::StrCat(field, ".heading_sigma_deg"),
                               message.heading_sigma_deg(), kMinHeadingSigma_deg, 180.0));
  } else if (message.heading_sigma_deg() != 0.0) {
    status.Update(
        Missing(absl::StrCat(field, ".heading_deg, which heading_sigma_deg belongs to,")));
  }
  return status;
}

}  // namespace

absl::StatusOr<InitialPose> FromProto(const v1::PoseWithCovariance& message,
                                      absl::string_view field) {
  const std::string pose_field = absl::StrCat(field, ".pose");
  if (!message.has_pose()) return Missing(pose_field);
  absl::StatusOr<Pose3> pose = FromProto(message.pose(), pose_field);
  if (!pose.ok()) return pose.status();
  absl::StatusOr<Matrix6d> covariance =
      CovarianceFromProto(message.covariance(), absl::StrCat(field, ".covariance"));
  if (!covariance.ok()) return covariance.status();
  return InitialPose{.T_map_vehicle = *pose,
                     .covariance = TangentFromFixedAxes(*pose, *covariance)};
}

absl::StatusOr<InitialPose> FromProto(const v1::GnssFix& message,
                                      const std::optional<GeodeticAnchor>& anchor,
                                      absl::string_view field) {
  if (absl::Status status = Check(message, field); !status.ok()) return status;
  const std::string position_field = absl::StrCat(field, ".position");
  if (!message.has_position()) return Missing(position_field);
  const absl::StatusOr<GeodeticPosition> position = FromProto(message.position(), position_field);
  if (!position.ok()) return position.status();
  if (!anchor) {
    return absl::FailedPreconditionError(
        absl::StrCat(field, " is of no use in this map: it has no anchor on the Earth"));
  }
  GnssFix fix{.position = *position,
              .horizontal_sigma_m = message.horizontal_sigma_m(),
              .vertical_sigma_m = message.vertical_sigma_m(),
              .heading_deg = {},
              .heading_sigma_deg = message.heading_sigma_deg()};
  if (message.has_heading_deg()) fix.heading_deg = message.heading_deg();
  return PriorFromGnss(fix, *anchor);
}

}  // namespace dcloc::server::convert
