#include "server/sessions/session.h"

#include <algorithm>
#include <utility>

#include "server/base/status.h"
#include "server/base/within_memory.h"
#include "server/convert/scan.h"
#include "server/sessions/session_log.h"
#include "server/sessions/stage_timer.h"

namespace dcloc::server {
namespace {

/// Each target takes a third of a microsecond, so these take one to two milliseconds.
constexpr float kQuickTargetCount = 4000.0F;
/// A scan: half of it is forgotten after 35. Who sends a large scan now and then is not quick.
constexpr float kUsualTargetDecay = 0.98F;

void SetStages(const StageTimer& timer, ScanTimings* timings) {
  timings->compensation = timer.duration(Stage::kCompensation);
  timings->submap = timer.duration(Stage::kSubmap);
  timings->registration = timer.duration(Stage::kRegistration);
  timings->posegraph = timer.duration(Stage::kPoseGraph);
}

/// A scan that is replayed for its motion alone, as its targets are in the resumed pose already.
/// Without a reported ego-velocity they are kept: their Doppler is the only source of the motion.
Scan MotionOf(const Scan& scan) {
  if (!scan.ego_velocity) return scan;
  return {.stamp = scan.stamp,
          .radar_id = scan.radar_id,
          .ego_velocity = scan.ego_velocity,
          .ticks = scan.ticks};
}

/// The newest scan that the localizer of `snapshot` had, as far as a move needs it.
Scan LastScanOf(const LocalizerSnapshot& snapshot, const Rig& rig) {
  Scan scan{.stamp = snapshot.stamp,
            .radar_id = rig.radars.front().id,
            .ego_velocity = snapshot.velocity};
  // It is that radar's stamp.
  if (!snapshot.clocks_ahead.empty()) scan.stamp += snapshot.clocks_ahead.front();
  return scan;
}

/// `resets` of a localizer that goes on where others ended.
void AddResetsBefore(const PoseResets& before, PoseResets* resets) {
  if (resets->count == 0) resets->T_before_after = before.T_before_after;
  resets->count += before.count;
}

/// Two maps' frames lie at the same place of the Earth, as far as is known.
bool SamePlace(const std::optional<GeodeticAnchor>& a, const std::optional<GeodeticAnchor>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  return a->origin.latitude_deg == b->origin.latitude_deg &&
         a->origin.longitude_deg == b->origin.longitude_deg &&
         a->origin.height_m == b->origin.height_m && a->x_axis_east_rad == b->x_axis_east_rad;
}

}  // namespace

absl::StatusOr<std::shared_ptr<Session>> Session::Create(const SessionContext& context,
                                                         SessionStart start) {
  absl::StatusOr<std::unique_ptr<ScanLocalizer>> localizer =
      context.create_localizer(start.map.map, start.rig, start.initial_pose, start.options);
  if (!localizer.ok()) return localizer.status();
  if (start.ticket) {
    if ((*localizer)->Restore(start.ticket->snapshot).ok()) {
      start.initial_pose = start.ticket->snapshot.pose;
    } else {
      start.ticket.reset();
      start.ticket_use = TicketUse::kUnusable;
    }
  }
  return std::shared_ptr<Session>(new Session(context, std::move(start), *std::move(localizer)));
}

Session::Session(const SessionContext& context, SessionStart start,
                 std::unique_ptr<ScanLocalizer> localizer)
    : context_(context),
      info_(std::move(start.info)),
      strand_(context.pool),
      map_(std::move(start.map)),
      rig_(std::make_shared<const Rig>(std::move(start.rig))),
      options_(start.options),
      localizer_(std::move(localizer)),
      last_pose_(std::move(start.initial_pose)),
      health_(info_, context_.metrics),
      ticket_writer_(context.tickets, info_, std::move(start.binding)),
      ticket_use_(start.ticket_use),
      answered_until_(start.ticket ? start.answered_until : std::nullopt),
      history_(context.answer_history_count),
      passes_(std::move(start.passes)) {
  if (start.ticket) {
    sequence_check_.Restore(start.ticket->last_sequence_number, start.ticket->snapshot.stamp);
    last_scan_ = LastScanOf(start.ticket->snapshot, *rig_);
    last_resets_ = start.ticket->snapshot.resets;
    ChooseLane();
    LogGoesOn(*info_, start.ticket->session_id);
  } else {
    strand_.SetLane(Lane::kLengthy);  // it will search; how large its scans are is not known
  }
  LogOpened(*info_, rig_->radars.size());
}

Session::~Session() {
  info_->feed.Close();
  if (recording_ != nullptr) recording_->OnEnd(absl::OkStatus());
  LogClosed(*info_);
}

OpenedSession Session::Describe(bool resumed) const {
  const SessionDescription& description = info_->description;
  OpenedSession opened{.session_id = description.session_id,
                       .map_name = description.map_name,
                       .map_version = info_->map_version,
                       .anchor = map_.map->info().anchor,
                       .resume_token = description.resume_token,
                       .resumed = resumed,
                       .last_sequence_number = std::nullopt,
                       .answer_history_count = context_.answer_history_count,
                       .detached_timeout = {},
                       .ticket_use = resumed ? TicketUse::kNone : ticket_use_,
                       .epoch = description.epoch,
                       .ticket_interval = {}};
  if (sequence_check_.last_localized() >= 0) {
    opened.last_sequence_number = sequence_check_.last_localized();
  }
  if (description.resumable()) opened.detached_timeout = context_.detached_timeout;
  if (ticket_writer_.writes()) opened.ticket_interval = context_.tickets->interval();
  return opened;
}

void Session::Record(std::shared_ptr<RecordingSubscriber> subscriber, const v1::OpenSession& open) {
  const absl::Status told = WithinMemory([&] {
    v1::OpenSession without_secret = open;
    without_secret.clear_ticket();
    without_secret.clear_resume_token();
    RecordingStart start{.open = without_secret,
                         .session = Describe(/*resumed=*/false),
                         .open_time = info_->description.open_time,
                         .map_sha256 = map_.record.sha256};
    start.session.resume_token.clear();
    subscriber->OnOpened(start);
  });
  if (!told.ok()) return subscriber->OnEnd(told);
  recording_ = std::move(subscriber);
  info_->recorded = true;
}

void Session::Answer(const v1::Scan& scan, const Arrival& arrival, Reply reply) {
  const Clock::time_point begin = Clock::now();
  info_->last_activity = begin;
  if (AnswerFromHistory(scan.sequence_number(), reply)) return;
  ScanAnswer answer{.sequence_number = scan.sequence_number(), .result = Localize(scan)};
  if (answer.result.ok()) {
    ScanTimings& timings = answer.result->timings;
    timings.queue = begin - arrival.steady;
    timings.total = Clock::now() - arrival.steady;
    timings.stamp_age =
        arrival.system.time_since_epoch() - std::chrono::nanoseconds(scan.stamp_ns());
    info_->last_stamp_age_ns = timings.stamp_age.count();
    answer.ticket =
        ticket_writer_.OnAnswered(answer.sequence_number, *answer.result, map_.record, *localizer_);
    if (answer.ticket) context_.metrics.ObserveTicket(answer.ticket->sealed.size());
  }
  Count(answer);
  answer.dropped_scan_count = info_->counts.dropped;
  Deliver(scan, answer, reply);
  if (!answer.result.ok()) return;
  if (passes_ != nullptr) passes_->OnLocalized(scan, *answer.result);
  const std::chrono::nanoseconds encoding = Clock::now() - localized_time_;
  context_.metrics.ObserveLocalized(*answer.result, encoding);
  LogLocalized(*info_, answer.sequence_number, *answer.result, encoding);
  health_.OnLocalized(*answer.result, begin);
  WarnOfBeta(scan.radar_id(), answer.result->localization.quality.beta);
}

void Session::CatchUp(const v1::Scan& scan) {
  info_->last_activity = Clock::now();
  const absl::Status status = Localize(scan).status();
  context_.metrics.ObserveCatchUp();
  if (!status.ok()) LogRejected(*info_, scan.sequence_number(), status);
}

void Session::TakeFix(const v1::PositionFix& fix, FixReply reply) {
  const FixAnswer answer{.stamp_ns = fix.stamp_ns(), .use = Use(fix)};
  ++info_->position_fix_count;
  context_.metrics.ObserveFix(answer.use);
  reply(answer);
  info_->feed.Publish(answer);
  if (recording_ != nullptr) recording_->OnFix(fix, answer);
}

absl::StatusOr<FixAnswer> Session::ProposePose(v1::PositionFix fix) {
  if (!sequence_check_.last_stamp()) {
    return absl::FailedPreconditionError("no scan of the session has been localized yet");
  }
  if (recording_ != nullptr && !recording_->TakesFixes()) {
    return absl::FailedPreconditionError(
        "the session is recorded by a client that cannot record position fixes");
  }
  if (fix.stamp_ns() == 0) {
    fix.set_stamp_ns(sequence_check_.last_stamp()->time_since_epoch().count());
  }
  std::optional<FixAnswer> taken;
  TakeFix(fix, [&taken](const FixAnswer& answer) { taken = answer; });
  return *std::move(taken);
}

absl::StatusOr<FixUse> Session::Use(const v1::PositionFix& message) {
  absl::Status status = info_->description.caller.permit->ChargeFix(Clock::now());
  if (!status.ok()) return status;
  const absl::StatusOr<PositionFix> fix = convert::FromProto(message, map_.map->info().anchor);
  if (!fix.ok()) return fix.status();
  absl::StatusOr<FixUse> use = localizer_->TakeFix(*fix);
  ChooseLane();
  if (!use.ok()) return WithPrefix("position_fix: ", use.status());
  return use;
}

void Session::AnswerDropped(std::int64_t sequence_number, Reply reply) {
  ++info_->counts.dropped;
  ++context_.totals.dropped;
  context_.metrics.ObserveDropped();
  info_->missing_scan_count += sequence_check_.OnDropped(sequence_number);
  const ScanAnswer answer{
      .sequence_number = sequence_number,
      .result = absl::ResourceExhaustedError("scan dropped: newer ones were waiting"),
      .dropped_scan_count = info_->counts.dropped};
  LogRejected(*info_, sequence_number, answer.result.status());
  reply(answer);
  info_->feed.Publish(answer, nullptr);
  history_.Keep(answer);
  if (recording_ == nullptr) return;
  v1::Scan scan;  // its columns are gone
  scan.set_sequence_number(sequence_number);
  recording_->OnScan(scan, answer);
}

bool Session::AnswerFromHistory(std::int64_t sequence_number, Reply reply) {
  if (sequence_number < 0 || sequence_number > sequence_check_.last_localized()) return false;
  const ScanAnswer* kept = history_.Recall(sequence_number);
  if (kept == nullptr) return false;
  ScanAnswer answer = *kept;
  answer.from_memory = true;
  reply(answer);
  ++info_->counts.repeated;
  ++context_.totals.repeated;
  context_.metrics.ObserveRepeated();
  return true;
}

absl::StatusOr<LocalizedScan> Session::Localize(const v1::Scan& message) {
  const Clock::time_point begin = Clock::now();
  if (absl::Status status = TakeScan(message, begin); !status.ok()) return status;
  const Clock::time_point converted = Clock::now();
  StageTimer timer;
  absl::StatusOr<Localization> localization = localizer_->Localize(scan_, &timer);
  timer.End();
  localized_time_ = Clock::now();
  if (!localization.ok()) return WithPrefix("scan: ", localization.status());
  AddResetsBefore(resets_before_move_, &localization->resets);
  OnLocalized(message, *localization);
  LocalizedScan scan{.map_version = info_->map_version,
                     .localization = *std::move(localization),
                     .rig = rig_,
                     .anchor = map_.map->info().anchor};
  scan.timings.conversion = converted - begin;
  SetStages(timer, &scan.timings);
  return scan;
}

/// Fills `scan_`, unless the principal may not send it, it is malformed, or out of order.
absl::Status Session::TakeScan(const v1::Scan& message, Clock::time_point begin) {
  absl::Status status = info_->description.caller.permit->ChargeScan(message.range_m_size(), begin);
  if (status.ok()) status = WithPrefix("scan.", convert::FromProto(message, *rig_, &scan_));
  if (status.ok()) status = sequence_check_.Check(message.sequence_number());
  return status;
}

void Session::OnLocalized(const v1::Scan& message, const Localization& localization) {
  info_->missing_scan_count += sequence_check_.OnLocalized(message.sequence_number(), scan_.stamp);
  std::swap(scan_, last_scan_);
  RememberPose(localization);
  last_resets_ = localization.resets;
  info_->last_sequence_number = sequence_check_.last_localized();
  info_->last_state = static_cast<int>(localization.state);
  usual_target_count_ =
      std::max(static_cast<float>(last_scan_.size()), kUsualTargetDecay * usual_target_count_);
  ChooseLane();
}

void Session::RememberPose(const Localization& localization) {
  // A session that began without any pose has none before the map has confirmed one. Who is lost
  // has one, however wide: its covariance says so.
  const bool unknown =
      localization.state == LocalizationState::kInitializing && !last_pose_.has_value();
  last_pose_.reset();
  if (!unknown) last_pose_ = {localization.T_map_vehicle, localization.covariance};
  if (unknown) return info_->pose.Set(std::nullopt);
  info_->pose.Set(LastPose::Value{.stamp_ns = localization.stamp.time_since_epoch().count(),
                                  .T_map_vehicle = localization.T_map_vehicle,
                                  .covariance = localization.covariance});
}

/// What takes milliseconds is done on the threads of lengthy tasks, so that no other session waits
/// for it: the search of a session that has not found its place yet, or has lost it, and large
/// scans.
void Session::ChooseLane() {
  const int state = info_->last_state;
  const bool claims_none = state == static_cast<int>(LocalizationState::kInitializing) ||
                           state == static_cast<int>(LocalizationState::kLost);
  const bool searches = claims_none || !localizer_->has_pose();
  const bool is_quick = !searches && usual_target_count_ <= kQuickTargetCount;
  strand_.SetLane(is_quick ? Lane::kQuick : Lane::kLengthy);
}

void Session::Count(const ScanAnswer& answer) {
  if (answer.result.ok()) {
    ++info_->counts.answered;
    ++context_.totals.answered;
    return;
  }
  ++info_->counts.rejected;
  ++context_.totals.rejected;
  context_.metrics.ObserveRejection(answer.result.status().code());
  LogRejected(*info_, answer.sequence_number, answer.result.status());
}

// Once for each radar: it stays wrong until somebody calibrates it.
void Session::WarnOfBeta(const std::string& radar_id, const BetaCheck& beta) {
  if (!beta.is_wrong || !radars_warned_of_.insert(radar_id).second) return;
  LogBetaContradicted(*info_, radar_id, beta);
}

void Session::Deliver(const v1::Scan& scan, ScanAnswer& answer, Reply reply) {
  reply(answer);
  answer.ticket.reset();
  info_->feed.Publish(answer, &scan);
  // One that is late stays so, and must not push out an answer that may still be wanted.
  const bool late =
      !answer.result.ok() && answer.sequence_number <= sequence_check_.last_localized();
  if (!late) history_.Keep(answer);
  if (recording_ != nullptr) recording_->OnScan(scan, answer);
}

absl::Status Session::Move(LoadedMap map) {
  const std::int64_t version = map.record.version;
  if (version == info_->map_version) return absl::OkStatus();
  if (!SamePlace(map.map->info().anchor, map_.map->info().anchor)) {
    return absl::FailedPreconditionError("the versions' anchors on the Earth differ");
  }
  absl::StatusOr<std::unique_ptr<ScanLocalizer>> localizer =
      context_.create_localizer(map.map, *rig_, last_pose_, options_);
  if (!localizer.ok()) return localizer.status();
  // The pose holds at the last scan's stamp, and the vehicle has moved on since.
  if (sequence_check_.last_stamp()) {
    absl::Status status = (*localizer)->Localize(MotionOf(last_scan_), nullptr).status();
    if (!status.ok()) return status;
  }
  localizer_ = *std::move(localizer);
  resets_before_move_ = last_resets_;
  ticket_writer_.OnMoved();
  ChooseLane();
  map_ = std::move(map);
  LogMoved(*info_, version);
  info_->map_version = version;
  return absl::OkStatus();
}

}  // namespace dcloc::server
