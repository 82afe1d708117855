#include "server/localization/session.h"

#include <openssl/rand.h>

#include <array>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/str_format.h"
#include "server/convert/geometry.h"
#include "server/convert/scan.h"
#include "server/convert/session.h"
#include "server/localization/stage_timer.h"
#include "server/status.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

using Clock = StageTimer::Clock;

/// 128 random bits: a session's name is nothing that can be guessed.
absl::StatusOr<std::string> NewSessionId() {
  std::array<unsigned char, 16> bytes{};
  if (RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) != 1) {
    return absl::InternalError("no random bytes for a session id");
  }
  return absl::BytesToHexString({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

std::int64_t Nanoseconds(std::chrono::nanoseconds duration) { return duration.count(); }

void SetStages(const StageTimer& timer, v1::StageTimings* timings) {
  timings->set_compensation_duration_ns(Nanoseconds(timer.duration(Stage::kCompensation)));
  timings->set_submap_duration_ns(Nanoseconds(timer.duration(Stage::kSubmap)));
  timings->set_registration_duration_ns(Nanoseconds(timer.duration(Stage::kRegistration)));
  timings->set_posegraph_duration_ns(Nanoseconds(timer.duration(Stage::kPoseGraph)));
}

}  // namespace

absl::StatusOr<std::unique_ptr<Session>> Session::Open(const v1::OpenSession& open,
                                                       const std::string& peer, MapStore& store,
                                                       SessionRegistry& registry,
                                                       MatcherFactory* create_matcher) {
  absl::StatusOr<convert::SessionRequest> request = convert::FromProto(open);
  if (!request.ok()) return request.status();
  absl::StatusOr<LoadedMap> map = store.Acquire(request->map_name, request->map_version);
  if (!map.ok()) return WithPrefix("open.map: ", map.status());
  const absl::StatusOr<std::optional<InitialPose>> initial_pose =
      convert::InitialPoseFromProto(open, map->map->info().anchor);
  if (!initial_pose.ok()) return initial_pose.status();
  absl::StatusOr<std::unique_ptr<Matcher>> matcher =
      create_matcher(map->map, request->rig, *initial_pose, request->options);
  if (!matcher.ok()) return WithPrefix("open: ", matcher.status());
  absl::StatusOr<std::string> session_id = NewSessionId();
  if (!session_id.ok()) return session_id.status();
  std::shared_ptr<SessionRecord> record =
      registry.Add({.session_id = *std::move(session_id),
                    .vehicle_id = request->vehicle_id,
                    .peer = peer,
                    .map_name = request->map_name,
                    .map_version = map->record.version,
                    .open_time = std::chrono::system_clock::now()});
  return std::unique_ptr<Session>(new Session(std::move(record), registry.totals(), *std::move(map),
                                              std::move(request->rig), *std::move(matcher)));
}

Session::Session(std::shared_ptr<SessionRecord> record, ScanCounts& totals, LoadedMap map, Rig rig,
                 std::unique_ptr<Matcher> matcher)
    : record_(std::move(record)),
      totals_(totals),
      map_(std::move(map)),
      rig_(std::move(rig)),
      matcher_(std::move(matcher)) {
  const SessionDescription& description = record_->description;
  spdlog::info("session opened session={} vehicle={} peer={} map={} version={} radars={}",
               description.session_id, description.vehicle_id, description.peer,
               description.map_name, description.map_version, rig_.radars.size());
}

Session::~Session() {
  spdlog::info("session closed session={} vehicle={} scans={} rejected={}",
               record_->description.session_id, record_->description.vehicle_id,
               record_->counts.answered.load(), record_->counts.rejected.load());
}

void Session::Describe(v1::SessionOpened* opened) const {
  opened->set_session_id(record_->description.session_id);
  opened->set_map_name(record_->description.map_name);
  opened->set_map_version(record_->description.map_version);
  const MapInfo& info = map_.map->info();
  if (info.anchor) convert::ToProto(*info.anchor, opened->mutable_anchor());
}

void Session::Answer(const v1::Scan& scan, Clock::time_point arrival,
                     v1::LocalizeResponse* response) {
  const Clock::time_point begin = Clock::now();
  v1::LocalizationResult* result = response->mutable_result();
  if (const absl::Status status = Localize(scan, result); !status.ok()) {
    Reject(scan, status, response->mutable_rejected());
    return;
  }
  result->mutable_timings()->set_queue_duration_ns(Nanoseconds(begin - arrival));
  result->mutable_timings()->set_total_duration_ns(Nanoseconds(Clock::now() - arrival));
  ++record_->counts.answered;
  ++totals_.answered;
}

absl::Status Session::Localize(const v1::Scan& message, v1::LocalizationResult* result) {
  const Clock::time_point begin = Clock::now();
  absl::Status status = WithPrefix("scan.", convert::FromProto(message, rig_, &scan_));
  if (!status.ok()) return status;
  if (message.sequence_number() <= last_sequence_number_) {
    return absl::InvalidArgumentError(
        absl::StrFormat("scan.sequence_number is %d; it must be above %d, the last one's",
                        message.sequence_number(), last_sequence_number_));
  }
  const Clock::time_point converted = Clock::now();
  StageTimer timer;
  const absl::StatusOr<Localization> localization = matcher_->Localize(scan_, &timer);
  timer.End();
  if (!localization.ok()) return WithPrefix("scan: ", localization.status());
  last_sequence_number_ = message.sequence_number();
  record_->last_state = static_cast<int>(localization->state);

  // Every field is set each time, so nothing of an earlier answer shows through.
  result->set_sequence_number(message.sequence_number());
  result->set_map_version(record_->description.map_version);
  convert::ToProto(*localization, result);
  result->mutable_timings()->set_conversion_duration_ns(Nanoseconds(converted - begin));
  SetStages(timer, result->mutable_timings());
  if (const std::optional<GeodeticAnchor>& anchor = map_.map->info().anchor) {
    convert::ToProto(*anchor, localization->T_map_vehicle, result->mutable_geodetic_pose());
  }
  return absl::OkStatus();
}

void Session::Reject(const v1::Scan& message, const absl::Status& status,
                     v1::ScanRejected* rejected) {
  rejected->set_sequence_number(message.sequence_number());
  rejected->set_code(static_cast<std::int32_t>(status.code()));
  rejected->set_message(std::string(status.message()));
  ++record_->counts.rejected;
  ++totals_.rejected;
  spdlog::debug("scan rejected session={} sequence_number={} reason={}",
                record_->description.session_id, message.sequence_number(),
                Quoted(status.message()));
}

}  // namespace dcloc::server
