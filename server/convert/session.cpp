#include "server/convert/session.h"

#include <limits>

#include "absl/strings/str_cat.h"
#include "core/geometry/covariance.h"
#include "core/relocalization/gnss_prior.h"
#include "server/base/check.h"
#include "server/base/status.h"
#include "server/convert/geometry.h"
#include "server/convert/scan.h"

namespace dcloc::server::convert {
namespace {

constexpr double kMaxGnssSigma_m = 1e4;
constexpr double kMinGnssSigma_m = 1e-3;
constexpr double kMinHeadingSigma_deg = 1e-3;

LocalizerOptions OptionsFromProto(const v1::LocalizationOptions& message) {
  LocalizerOptions options;
  if (message.has_scans_per_submap()) options.scans_per_submap = message.scans_per_submap();
  if (message.has_doppler_compensation()) {
    options.doppler_compensation = message.doppler_compensation();
  }
  if (message.has_uncertainty()) options.uncertainty = message.uncertainty();
  if (message.has_truncation()) options.truncation = message.truncation();
  return options;
}

absl::StatusOr<InitialPose> PoseFromProto(const v1::PoseWithCovariance& message) {
  if (!message.has_pose()) return Missing("open.initial_pose.pose");
  absl::StatusOr<Pose3> pose = FromProto(message.pose(), "open.initial_pose.pose");
  if (!pose.ok()) return pose.status();
  absl::StatusOr<Matrix6d> covariance =
      CovarianceFromProto(message.covariance(), "open.initial_pose.covariance");
  if (!covariance.ok()) return covariance.status();
  return InitialPose{.T_map_vehicle = *pose,
                     .covariance = TangentFromFixedAxes(*pose, *covariance)};
}

absl::Status Check(const v1::GnssFix& message) {
  absl::Status status =
      CheckBetween("open.gnss_fix.horizontal_sigma_m", message.horizontal_sigma_m(),
                   kMinGnssSigma_m, kMaxGnssSigma_m);
  status.Update(CheckBetween("open.gnss_fix.vertical_sigma_m", message.vertical_sigma_m(),
                             kMinGnssSigma_m, kMaxGnssSigma_m));
  if (message.has_heading_deg()) {
    status.Update(CheckBetween("open.gnss_fix.heading_deg", message.heading_deg(), 0.0, 360.0));
    status.Update(CheckBetween("open.gnss_fix.heading_sigma_deg", message.heading_sigma_deg(),
                               kMinHeadingSigma_deg, 180.0));
  } else if (message.heading_sigma_deg() != 0.0) {
    status.Update(Missing("open.gnss_fix.heading_deg, which heading_sigma_deg belongs to,"));
  }
  return status;
}

absl::StatusOr<InitialPose> FixFromProto(const v1::GnssFix& message,
                                         const std::optional<GeodeticAnchor>& anchor) {
  if (absl::Status status = Check(message); !status.ok()) return status;
  if (!message.has_position()) return Missing("open.gnss_fix.position");
  const absl::StatusOr<GeodeticPosition> position =
      FromProto(message.position(), "open.gnss_fix.position");
  if (!position.ok()) return position.status();
  if (!anchor) {
    return absl::FailedPreconditionError(
        "open.gnss_fix is of no use in this map: it has no anchor on the Earth");
  }
  GnssFix fix{.position = *position,
              .horizontal_sigma_m = message.horizontal_sigma_m(),
              .vertical_sigma_m = message.vertical_sigma_m(),
              .heading_deg = {},
              .heading_sigma_deg = message.heading_sigma_deg()};
  if (message.has_heading_deg()) fix.heading_deg = message.heading_deg();
  return PriorFromGnss(fix, *anchor);
}

}  // namespace

absl::StatusOr<SessionRequest> FromProto(const v1::OpenSession& message) {
  absl::Status status = CheckId("open.vehicle_id", message.vehicle_id());
  status.Update(CheckMapName("open.map_name", message.map_name()));
  status.Update(CheckIntegerBetween("open.map_version", message.map_version(), 0,
                                    std::numeric_limits<std::int64_t>::max()));
  if (!status.ok()) return status;
  absl::StatusOr<Rig> rig = FromProto(message.rig(), "open.rig");
  if (!rig.ok()) return rig.status();
  const LocalizerOptions options = OptionsFromProto(message.options());
  status = WithPrefix("open.options: ", Validate(options));
  if (!status.ok()) return status;
  return SessionRequest{.vehicle_id = message.vehicle_id(),
                        .map_name = message.map_name(),
                        .map_version = message.map_version(),
                        .rig = *std::move(rig),
                        .options = options};
}

absl::StatusOr<std::optional<InitialPose>> InitialPoseFromProto(
    const v1::OpenSession& message, const std::optional<GeodeticAnchor>& anchor) {
  if (!message.has_initial_pose() && !message.has_gnss_fix()) return std::nullopt;
  absl::StatusOr<InitialPose> pose = message.has_initial_pose()
                                         ? PoseFromProto(message.initial_pose())
                                         : FixFromProto(message.gnss_fix(), anchor);
  if (!pose.ok()) return pose.status();
  return *pose;
}

void ToProto(const OpenedSession& session, v1::SessionOpened* message) {
  message->set_session_id(session.session_id);
  message->set_map_name(session.map_name);
  message->set_map_version(session.map_version);
  if (session.anchor) ToProto(*session.anchor, message->mutable_anchor());
  message->set_resume_token(session.resume_token);
  message->set_resumed(session.resumed);
  if (session.last_sequence_number) {
    message->set_last_sequence_number(*session.last_sequence_number);
  }
  message->set_answer_history_count(session.answer_history_count);
  message->set_detached_timeout_ns(session.detached_timeout.count());
}

}  // namespace dcloc::server::convert
