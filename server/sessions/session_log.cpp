#include "server/sessions/session_log.h"

#include "core/geometry/degrees.h"
#include "server/base/status.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

std::int64_t Microseconds(std::chrono::nanoseconds duration) { return duration.count() / 1000; }

}  // namespace

void LogOpened(const SessionInfo& info, std::size_t radar_count) {
  const SessionDescription& description = info.description;
  spdlog::info("session opened session={} vehicle={} peer={} map={} version={} radars={} trace={}",
               description.session_id, description.vehicle_id, description.caller.peer,
               description.map_name, info.map_version.load(), radar_count,
               description.caller.trace_id);
}

void LogGoesOn(const SessionInfo& info, const std::string& before) {
  spdlog::info("session goes on session={} vehicle={} from={} epoch={}",
               info.description.session_id, info.description.vehicle_id, before,
               info.description.epoch);
}

void LogTicketNotTaken(const SessionInfo& info, TicketUse use, const std::string& key_id) {
  spdlog::warn("ticket not taken session={} vehicle={} peer={} reason={} key={}",
               info.description.session_id, info.description.vehicle_id,
               info.description.caller.peer, NameOf(use), key_id);
}

void LogMoved(const SessionInfo& info, std::int64_t to_version) {
  spdlog::info("session moved session={} vehicle={} from={} to={}", info.description.session_id,
               info.description.vehicle_id, info.map_version.load(), to_version);
}

void LogClosed(const SessionInfo& info) {
  spdlog::info("session closed session={} vehicle={} scans={} rejected={} repeated={} dropped={}",
               info.description.session_id, info.description.vehicle_id,
               info.counts.answered.load(), info.counts.rejected.load(),
               info.counts.repeated.load(), info.counts.dropped.load());
}

void LogLocalized(const SessionInfo& info, std::int64_t sequence_number, const LocalizedScan& scan,
                  std::chrono::nanoseconds encoding) {
  if (!spdlog::should_log(spdlog::level::debug)) return;
  const ScanTimings& timings = scan.timings;
  spdlog::debug(
      "scan localized session={} trace={} sequence_number={} state={} queue_us={} conversion_us={} "
      "compensation_us={} submap_us={} registration_us={} posegraph_us={} encoding_us={}",
      info.description.session_id, info.description.caller.trace_id, sequence_number,
      v1::LocalizationState_Name(convert::ToProto(scan.localization.state)),
      Microseconds(timings.queue), Microseconds(timings.conversion),
      Microseconds(timings.compensation), Microseconds(timings.submap),
      Microseconds(timings.registration), Microseconds(timings.posegraph), Microseconds(encoding));
}

void LogRejected(const SessionInfo& info, std::int64_t sequence_number,
                 const absl::Status& status) {
  if (!spdlog::should_log(spdlog::level::debug)) return;
  spdlog::debug("scan rejected session={} trace={} sequence_number={} reason={}",
                info.description.session_id, info.description.caller.trace_id, sequence_number,
                Quoted(status.message()));
}

void LogBetaContradicted(const SessionInfo& info, const std::string& radar_id,
                         const BetaCheck& beta) {
  spdlog::warn(
      "beta contradicted session={} vehicle={} radar={} beta_error_s={:.4f} sigma_s={:.4f}",
      info.description.session_id, info.description.vehicle_id, radar_id, beta.error_s,
      beta.sigma_s);
}

void LogSource(const SessionInfo& info, const Rig& rig, const SourceChange& change) {
  const bool is_radar = change.kind == SourceKind::kRadar;
  const char* const name = kSourceKindNames[static_cast<std::size_t>(change.kind)];
  spdlog::warn("{} session={} vehicle={} source={} reason={} changes={}",
               change.health.is_used ? "source taken back" : "source set aside",
               info.description.session_id, info.description.vehicle_id,
               is_radar ? rig.radars.at(change.radar_index).id : name, NameOf(change.health.fault),
               change.change_count);
}

void LogReset(const SessionInfo& info, const PoseResets& resets) {
  const Pose3& jump = resets.T_before_after;
  const double angle_rad = Eigen::AngleAxisd(jump.rotation).angle();
  spdlog::warn("pose reset session={} vehicle={} distance_m={:.2f} rotation_deg={:.2f} count={}",
               info.description.session_id, info.description.vehicle_id, jump.translation_m.norm(),
               angle_rad * kDegPerRad, resets.count);
}

}  // namespace dcloc::server
