#include "server/convert/session.h"

#include <limits>
#include <utility>

#include "server/base/check.h"
#include "server/base/status.h"
#include "server/convert/geometry.h"
#include "server/convert/initial_pose.h"
#include "server/convert/learned_rig.h"
#include "server/convert/scan.h"

namespace dcloc::server::convert {
namespace {

static_assert(v1::TicketUse_MAX == v1::TICKET_USE_UNUSABLE &&
              kTicketUseNames.size() == v1::TicketUse_ARRAYSIZE);

LocalizerOptions OptionsFromProto(const v1::LocalizationOptions& message) {
  LocalizerOptions options;
  if (message.has_scans_per_submap()) options.scans_per_submap = message.scans_per_submap();
  if (message.has_doppler_compensation()) {
    options.doppler_compensation = message.doppler_compensation();
  }
  if (message.has_uncertainty()) options.per_point_covariance = message.uncertainty();
  if (message.has_truncation()) options.gate_outliers = message.truncation();
  return options;
}

}  // namespace

absl::StatusOr<SessionRequest> FromProto(const v1::OpenSession& message) {
  absl::Status status = CheckId("open.vehicle_id", message.vehicle_id());
  status.Update(CheckMapName("open.map_name", message.map_name()));
  status.Update(CheckIntegerBetween("open.map_version", message.map_version(), 0,
                                    std::numeric_limits<std::int64_t>::max()));
  status.Update(CheckIntegerBetween("open.epoch", message.epoch(), 0, kMaxEpoch));
  if (!status.ok()) return status;
  absl::StatusOr<Rig> rig = FromProto(message.rig(), "open.rig");
  if (!rig.ok()) return rig.status();
  LocalizerOptions options = OptionsFromProto(message.options());
  if (message.has_learned_rig()) {
    absl::StatusOr<RigKnowledge> known = FromProto(message.learned_rig(), "open.learned_rig");
    if (!known.ok()) return known.status();
    options.known = *std::move(known);
  }
  status = WithPrefix("open.options: ", Validate(options));
  if (!status.ok()) return status;
  return SessionRequest{.vehicle_id = message.vehicle_id(),
                        .map_name = message.map_name(),
                        .map_version = message.map_version(),
                        .rig = *std::move(rig),
                        .options = options,
                        .epoch = message.epoch()};
}

absl::StatusOr<std::optional<InitialPose>> InitialPoseFromProto(
    const v1::OpenSession& message, const std::optional<GeodeticAnchor>& anchor) {
  if (!message.has_initial_pose() && !message.has_gnss_fix()) return std::nullopt;
  absl::StatusOr<InitialPose> pose = message.has_initial_pose()
                                         ? FromProto(message.initial_pose(), "open.initial_pose")
                                         : FromProto(message.gnss_fix(), anchor, "open.gnss_fix");
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
  message->set_takes_position_fixes(true);
  message->set_ticket_use(static_cast<v1::TicketUse>(session.ticket_use));
  message->set_epoch(session.epoch);
  message->set_ticket_interval_ns(session.ticket_interval.count());
}

}  // namespace dcloc::server::convert
