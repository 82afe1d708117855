#include "server/sessions/session.h"

#include <openssl/rand.h>

#include <array>
#include <string>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/str_format.h"
#include "google/protobuf/util/time_util.h"
#include "server/base/status.h"
#include "server/convert/geometry.h"
#include "server/convert/scan.h"
#include "server/convert/session.h"
#include "server/sessions/stage_timer.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

using Clock = StageTimer::Clock;

/// A recording has its own time, so any pace will do; but one wrong stamp far ahead would make all
/// right ones after it late.
constexpr std::chrono::hours kMaxStampStep(1);

/// 128 random bits in hexadecimal: nothing that can be guessed.
absl::StatusOr<std::string> RandomName() {
  std::array<unsigned char, 16> bytes{};
  if (RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) != 1) {
    return absl::InternalError("no random bytes for a session");
  }
  return absl::BytesToHexString({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

absl::StatusOr<std::shared_ptr<SessionRecord>> MakeRecord(const v1::OpenSession& open,
                                                          const Caller& caller,
                                                          const MapVersionRecord& map) {
  absl::StatusOr<std::string> session_id = RandomName();
  if (!session_id.ok()) return session_id.status();
  absl::StatusOr<std::string> resume_token = open.resumable() ? RandomName() : std::string();
  if (!resume_token.ok()) return resume_token.status();
  auto record = std::make_shared<SessionRecord>();
  record->description = {.session_id = *std::move(session_id),
                         .resume_token = *std::move(resume_token),
                         .vehicle_id = open.vehicle_id(),
                         .caller = caller,
                         .map_name = open.map_name(),
                         .map_version_asked_for = open.map_version() != 0,
                         .open_time = std::chrono::system_clock::now(),
                         .drops_oldest = open.queue_policy() == v1::QUEUE_POLICY_DROP_OLDEST};
  record->map_version = map.version;
  return record;
}

std::int64_t Nanoseconds(std::chrono::nanoseconds duration) { return duration.count(); }

void SetStages(const StageTimer& timer, v1::StageTimings* timings) {
  timings->set_compensation_duration_ns(Nanoseconds(timer.duration(Stage::kCompensation)));
  timings->set_submap_duration_ns(Nanoseconds(timer.duration(Stage::kSubmap)));
  timings->set_registration_duration_ns(Nanoseconds(timer.duration(Stage::kRegistration)));
  timings->set_posegraph_duration_ns(Nanoseconds(timer.duration(Stage::kPoseGraph)));
}

/// What a scan says of the vehicle's motion. Its targets are in the pose already; they are looked
/// at again only where the motion is known from nothing else.
Scan MotionOf(const Scan& scan) {
  if (!scan.ego_velocity) return scan;
  return {.stamp = scan.stamp, .radar_id = scan.radar_id, .ego_velocity = scan.ego_velocity};
}

/// Two maps' frames lie at the same place of the Earth, as far as is known.
bool SamePlace(const std::optional<GeodeticAnchor>& a, const std::optional<GeodeticAnchor>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  return a->origin.latitude_deg == b->origin.latitude_deg &&
         a->origin.longitude_deg == b->origin.longitude_deg &&
         a->origin.height_m == b->origin.height_m && a->x_axis_east_rad == b->x_axis_east_rad;
}

}  // namespace

absl::StatusOr<std::shared_ptr<Session>> Session::Open(const v1::OpenSession& open,
                                                       const Caller& caller,
                                                       const SessionContext& context) {
  absl::StatusOr<convert::SessionRequest> request = convert::FromProto(open);
  if (!request.ok()) return request.status();
  const Clock::time_point begin = Clock::now();
  const std::string map_name = ScopedMapName(caller.principal.tenant, request->map_name);
  absl::StatusOr<LoadedMap> map = request->map_version == 0
                                      ? context.store.AcquireFor(map_name, request->vehicle_id)
                                      : context.store.Acquire(map_name, request->map_version);
  if (!map.ok()) return WithPrefix("open.map: ", map.status());
  context.metrics.ObserveMapAcquired(Clock::now() - begin, map->was_in_memory);
  const absl::StatusOr<std::optional<InitialPose>> initial_pose =
      convert::InitialPoseFromProto(open, map->map->info().anchor);
  if (!initial_pose.ok()) return initial_pose.status();
  absl::StatusOr<std::unique_ptr<Matcher>> matcher =
      context.create_matcher(map->map, request->rig, *initial_pose, request->options);
  if (!matcher.ok()) return WithPrefix("open: ", matcher.status());
  absl::StatusOr<std::shared_ptr<SessionRecord>> record = MakeRecord(open, caller, map->record);
  if (!record.ok()) return record.status();
  std::shared_ptr<Session> session(new Session(context, *std::move(record), *std::move(map),
                                               *std::move(request), *std::move(matcher)));
  session->last_pose_ = *initial_pose;
  if (auto tap = context.taps.Take(caller.principal.tenant, open.vehicle_id())) {
    session->Tap(std::move(tap), open, context.program);
  }
  return session;
}

void Session::Tap(std::shared_ptr<SessionTap> tap, const v1::OpenSession& open,
                  const std::string& program) {
  v1::RecordingHeader header;
  header.set_program(program);
  *header.mutable_open_time() = google::protobuf::util::TimeUtil::NanosecondsToTimestamp(
      record_->description.open_time.time_since_epoch().count());
  *header.mutable_open() = open;
  Describe(/*resumed=*/false, header.mutable_opened());
  header.mutable_opened()->clear_resume_token();
  header.set_map_sha256(map_.record.sha256);
  tap->OnOpened(header);
  tap_ = std::move(tap);
  record_->recorded = true;
}

Session::Session(const SessionContext& context, std::shared_ptr<SessionRecord> record,
                 LoadedMap map, convert::SessionRequest request, std::unique_ptr<Matcher> matcher)
    : detached_timeout_(context.detached_timeout),
      answer_history_count_(context.answer_history_count),
      record_(std::move(record)),
      totals_(context.totals),
      metrics_(context.metrics),
      strand_(context.pool),
      create_matcher_(context.create_matcher),
      map_(std::move(map)),
      rig_(std::move(request.rig)),
      options_(request.options),
      matcher_(std::move(matcher)),
      history_(context.answer_history_count) {
  const SessionDescription& description = record_->description;
  spdlog::info("session opened session={} vehicle={} peer={} map={} version={} radars={} trace={}",
               description.session_id, description.vehicle_id, description.caller.peer,
               description.map_name, record_->map_version.load(), rig_.radars.size(),
               description.caller.trace_id);
}

Session::~Session() {
  record_->feed.Close();
  if (tap_ != nullptr) tap_->OnEnd();
  spdlog::info("session closed session={} vehicle={} scans={} rejected={} repeated={} dropped={}",
               record_->description.session_id, record_->description.vehicle_id,
               record_->counts.answered.load(), record_->counts.rejected.load(),
               record_->counts.repeated.load(), record_->counts.dropped.load());
}

void Session::Describe(bool resumed, v1::SessionOpened* opened) const {
  const SessionDescription& description = record_->description;
  opened->set_session_id(description.session_id);
  opened->set_map_name(description.map_name);
  opened->set_map_version(record_->map_version);
  const MapInfo& info = map_.map->info();
  if (info.anchor) convert::ToProto(*info.anchor, opened->mutable_anchor());
  opened->set_resume_token(description.resume_token);
  opened->set_resumed(resumed);
  if (last_sequence_number_ >= 0) opened->set_last_sequence_number(last_sequence_number_);
  opened->set_answer_history_count(answer_history_count_);
  opened->set_detached_timeout_ns(description.resumable() ? Nanoseconds(detached_timeout_) : 0);
}

void Session::Answer(const v1::Scan& scan, const Arrival& arrival, v1::LocalizeResponse* response) {
  const Clock::time_point begin = Clock::now();
  record_->last_activity = begin;
  const std::int64_t number = scan.sequence_number();
  if (number >= 0 && number <= last_sequence_number_ && history_.Recall(number, response)) {
    response->set_from_memory(true);
    ++record_->counts.repeated;
    ++totals_.repeated;
    metrics_.ObserveRepeated();
    return;
  }
  v1::LocalizationResult* result = response->mutable_result();
  const absl::Status status = Localize(scan, result);
  if (status.ok()) {
    v1::StageTimings* timings = result->mutable_timings();
    timings->set_queue_duration_ns(Nanoseconds(begin - arrival.steady));
    timings->set_total_duration_ns(Nanoseconds(Clock::now() - arrival.steady));
    timings->set_stamp_age_ns(Nanoseconds(arrival.system.time_since_epoch()) - scan.stamp_ns());
    record_->last_stamp_age_ns = timings->stamp_age_ns();
    ++record_->counts.answered;
    ++totals_.answered;
  } else {
    Reject(number, status, response->mutable_rejected());
    ++record_->counts.rejected;
    ++totals_.rejected;
    metrics_.ObserveRejection(status.code());
  }
  if (status.ok()) WarnOfBeta(scan.radar_id(), result->quality());
  Publish(response);
  // One that is late stays so, and must not push out an answer that may still be wanted.
  if (number > last_sequence_number_ || status.ok()) history_.Keep(number, *response);
  if (tap_ != nullptr) tap_->OnScan(scan, *response);
  if (!status.ok()) return;
  const std::chrono::nanoseconds encoding = Clock::now() - localized_;
  metrics_.ObserveAnswer(response->result(), encoding);
  LogStages(response->result(), encoding);
}

// Once for each radar: it stays wrong until somebody calibrates it.
void Session::WarnOfBeta(const std::string& radar_id, const v1::LocalizationQuality& quality) {
  if (!quality.beta_is_wrong() || !radars_warned_of_.insert(radar_id).second) return;
  spdlog::warn(
      "beta contradicted session={} vehicle={} radar={} beta_error_s={:.4f} sigma_s={:.4f}",
      record_->description.session_id, record_->description.vehicle_id, radar_id,
      quality.beta_error_s(), quality.beta_error_sigma_s());
}

void Session::LogStages(const v1::LocalizationResult& result,
                        std::chrono::nanoseconds encoding) const {
  if (!spdlog::should_log(spdlog::level::debug)) return;
  const v1::StageTimings& timings = result.timings();
  spdlog::debug(
      "scan localized session={} trace={} sequence_number={} state={} queue_us={} conversion_us={} "
      "compensation_us={} submap_us={} registration_us={} posegraph_us={} encoding_us={}",
      record_->description.session_id, record_->description.caller.trace_id,
      result.sequence_number(), v1::LocalizationState_Name(result.state()),
      timings.queue_duration_ns() / 1000, timings.conversion_duration_ns() / 1000,
      timings.compensation_duration_ns() / 1000, timings.submap_duration_ns() / 1000,
      timings.registration_duration_ns() / 1000, timings.posegraph_duration_ns() / 1000,
      encoding.count() / 1000);
}

void Session::AnswerDropped(std::int64_t sequence_number, v1::LocalizeResponse* response) {
  ++record_->counts.dropped;
  ++totals_.dropped;
  metrics_.ObserveDropped();
  CountMissing(sequence_number);
  Reject(sequence_number, absl::ResourceExhaustedError("scan dropped: newer ones were waiting"),
         response->mutable_rejected());
  Publish(response);
  history_.Keep(sequence_number, *response);
  if (tap_ == nullptr) return;
  v1::Scan scan;  // its columns are gone
  scan.set_sequence_number(sequence_number);
  tap_->OnScan(scan, *response);
}

absl::Status Session::CheckOrder(const v1::Scan& message) const {
  if (message.sequence_number() <= last_sequence_number_) {
    return absl::OutOfRangeError(absl::StrFormat(
        "scan.sequence_number is %d, which is late: %d has been processed, and no answer to the "
        "late one is in memory",
        message.sequence_number(), last_sequence_number_));
  }
  if (last_stamp_ && scan_.stamp - *last_stamp_ > kMaxStampStep) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "scan.stamp_ns is %d; it must lie at most %d h after %d, the newest scan's",
        message.stamp_ns(), kMaxStampStep.count(), last_stamp_->time_since_epoch().count()));
  }
  return absl::OkStatus();
}

absl::Status Session::Localize(const v1::Scan& message, v1::LocalizationResult* result) {
  const Clock::time_point begin = Clock::now();
  absl::Status status = record_->description.caller.permit->TakeScan(message.range_m_size(), begin);
  if (status.ok()) status = WithPrefix("scan.", convert::FromProto(message, rig_, &scan_));
  if (status.ok()) status = CheckOrder(message);
  if (!status.ok()) return status;
  const Clock::time_point converted = Clock::now();
  StageTimer timer;
  const absl::StatusOr<Localization> localization = matcher_->Localize(scan_, &timer);
  timer.End();
  localized_ = Clock::now();
  if (!localization.ok()) return WithPrefix("scan: ", localization.status());
  CountMissing(message.sequence_number());
  last_sequence_number_ = message.sequence_number();
  last_stamp_ = scan_.stamp;
  std::swap(scan_, last_scan_);
  RememberPose(*localization);
  ChooseLane();
  record_->last_sequence_number = last_sequence_number_;
  record_->last_state = static_cast<int>(localization->state);

  // Every field is set each time, so nothing of an earlier answer shows through.
  result->set_sequence_number(message.sequence_number());
  result->set_map_version(record_->map_version);
  convert::ToProto(*localization, result);
  result->mutable_timings()->set_conversion_duration_ns(Nanoseconds(converted - begin));
  SetStages(timer, result->mutable_timings());
  if (const std::optional<GeodeticAnchor>& anchor = map_.map->info().anchor) {
    convert::ToProto(*anchor, localization->T_map_vehicle, result->mutable_geodetic_pose());
  }
  return absl::OkStatus();
}

void Session::RememberPose(const Localization& localization) {
  // A session that began without any pose has none before the map has confirmed one. Who is lost
  // has one, however wide: its covariance says so.
  const bool unknown =
      localization.state == LocalizationState::kInitializing && !last_pose_.has_value();
  last_pose_.reset();
  if (!unknown) last_pose_ = {localization.T_map_vehicle, localization.covariance};
}

/// Whoever searches a whole map does so on a thread of its own, and nobody else waits for it.
void Session::ChooseLane() {
  strand_.SetLane(matcher_->searching() ? Lane::kLengthy : Lane::kQuick);
}

absl::Status Session::Move(LoadedMap map) {
  const std::int64_t version = map.record.version;
  if (version == record_->map_version) return absl::OkStatus();
  if (!SamePlace(map.map->info().anchor, map_.map->info().anchor)) {
    return absl::FailedPreconditionError("the versions' anchors on the Earth differ");
  }
  absl::StatusOr<std::unique_ptr<Matcher>> matcher =
      create_matcher_(map.map, rig_, last_pose_, options_);
  if (!matcher.ok()) return matcher.status();
  // The pose holds at the last scan's stamp, and the vehicle has moved on since.
  if (last_stamp_) {
    absl::Status status = (*matcher)->Localize(MotionOf(last_scan_), nullptr).status();
    if (!status.ok()) return status;
  }
  matcher_ = *std::move(matcher);
  ChooseLane();
  map_ = std::move(map);
  spdlog::info("session moved session={} vehicle={} from={} to={}", record_->description.session_id,
               record_->description.vehicle_id, record_->map_version.load(), version);
  record_->map_version = version;
  return absl::OkStatus();
}

void Session::CountMissing(std::int64_t sequence_number) {
  if (sequence_number <= highest_sequence_number_) return;
  if (highest_sequence_number_ >= 0) {
    record_->missing_scan_count += sequence_number - highest_sequence_number_ - 1;
  }
  highest_sequence_number_ = sequence_number;
}

void Session::Reject(std::int64_t sequence_number, const absl::Status& status,
                     v1::ScanRejected* rejected) const {
  rejected->set_sequence_number(sequence_number);
  rejected->set_code(static_cast<std::int32_t>(status.code()));
  rejected->set_message(std::string(status.message()));
  spdlog::debug("scan rejected session={} trace={} sequence_number={} reason={}",
                record_->description.session_id, record_->description.caller.trace_id,
                sequence_number, Quoted(status.message()));
}

void Session::Publish(v1::LocalizeResponse* response) {
  response->set_from_memory(false);
  response->set_dropped_scan_count(record_->counts.dropped);
  record_->feed.Publish(*response);
}

}  // namespace dcloc::server
