#include "client/load/vehicle.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/sdk/retry.h"
#include "client/sdk/status.h"

namespace dcloc::load {
namespace {

using Fill = client::Connection::Fill;

/// Scans that wait for the transport; what comes beyond is not sent.
constexpr std::size_t kMaxWaiting = 64;
/// Scans on their way, as with the SDK's defaults.
constexpr std::size_t kMaxUnanswered = 64;
constexpr std::chrono::milliseconds kResumeDelay(100);
constexpr std::chrono::milliseconds kRetryDelay(1000);

/// Never more on their way than the server keeps answers for.
std::size_t Window(const v1::SessionOpened& opened) {
  const auto kept = static_cast<std::size_t>(opened.answer_history_count());
  return kept == 0 ? kMaxUnanswered : std::min(kMaxUnanswered, kept);
}

std::string TextOf(const grpc::Status& status) {
  return absl::StrCat(status.error_message().empty() ? "ended early" : status.error_message(),
                      " (code ", static_cast<int>(status.error_code()), ")");
}

}  // namespace

Vehicle::Vehicle(int index, const Fleet& fleet, const Route& route, VehicleLink link)
    : index_(index),
      fleet_(fleet),
      route_(route),
      link_(std::move(link)),
      stub_(v1::LocalizationService::NewStub(link_.channel)),
      random_(fleet.options.seed * 1'000'003 + static_cast<std::uint64_t>(index)),
      is_slow_reader_(Chance(fleet.options.faults.slow_reader_share)) {}

Vehicle::~Vehicle() = default;

void Vehicle::Start() {
  const std::lock_guard lock(mutex_);
  state_ = Next(state_, VehicleEvent::kEnd);  // if it is to end before it has begun
  if (state_ == VehicleState::kDone) return;
  // Spread over the route, so that vehicles of one route do not ask for the same all the time.
  const double last =
      std::ceil(fleet_.options.begin_within * static_cast<double>(route_.scans.size()));
  BeginTrip(random_() % std::max<std::size_t>(1, static_cast<std::size_t>(last)));
}

void Vehicle::Finish() {
  const std::lock_guard lock(mutex_);
  state_ = Next(state_, VehicleEvent::kFinish);
  if (last_answer_ && !is_slow_reader_) fleet_.recorder.AddGap(*last_answer_, Clock::now());
  Flush();
  ReadOn();
}

void Vehicle::Cancel() {
  const std::lock_guard lock(mutex_);
  state_ = Next(state_, VehicleEvent::kCancel);
  if (HasStream()) {
    connection_->Cancel();
  } else if (connection_ == nullptr && state_ != VehicleState::kDone) {
    LoseOutbox();
    state_ = Next(state_, VehicleEvent::kEnd);
  }
}

bool Vehicle::done() const {
  const std::lock_guard lock(mutex_);
  return state_ == VehicleState::kDone;
}

/// A stream that has not ended.
bool Vehicle::HasStream() const { return connection_ != nullptr && !end_status_; }

/// Nothing new is sent.
bool Vehicle::IsEnding() const { return state_ != VehicleState::kDriving; }

void Vehicle::At(Clock::time_point time, void (Vehicle::*action)()) {
  fleet_.scheduler.At(time, [this, action, trip = trip_.number] {
    const std::lock_guard lock(mutex_);
    if (trip == trip_.number && state_ != VehicleState::kDone) (this->*action)();
  });
}

// ---- The trip

void Vehicle::BeginTrip(std::size_t first) {
  const std::int64_t number = trip_.number + 1;
  trip_ = {};
  trip_.number = number;
  trip_.first = trip_.next = first;
  OpenStream();
}

void Vehicle::OpenStream() {
  stream_ = Next(stream_, StreamEvent::kBegin);
  end_status_.reset();
  sent_count_ = 0;
  open_time_ = Clock::now();
  v1::OpenSession open = OpenMessage();
  if (trip_.resume_token.empty()) trip_.asks_for_version = open.map_version() != 0;
  connection_ = std::make_unique<client::Connection>(*stub_, mutex_, *this, std::move(open));
}

v1::OpenSession Vehicle::OpenMessage() const {
  v1::OpenSession open;
  if (trip_.resume_token.empty()) {
    open = route_.open(trip_.first, static_cast<std::uint64_t>(index_ * 1000L + trip_.number));
    open.set_resumable(true);
    open.set_queue_policy(fleet_.options.queue_policy);
    const std::size_t next = std::min(trip_.next, route_.scans.size() - 1);
    const v1::Scan& scan = outbox_.empty() ? route_.scans[next] : *outbox_.front().expected.scan;
    trip_.prior.Apply(scan.stamp_ns(), &open);
  } else {
    open.set_resume_token(trip_.resume_token);
  }
  open.set_vehicle_id(absl::StrFormat("load-%05d", index_));
  return open;
}

void Vehicle::PlanNextScan() {
  if (IsEnding() || trip_.next >= route_.scans.size()) return Flush();
  if (!fleet_.options.open_loop) {
    while (outbox_.empty() && trip_.next < route_.scans.size()) SendNext(Clock::now());
    return;
  }
  const double recorded_ns = static_cast<double>(route_.scans[trip_.next].stamp_ns() -
                                                 route_.scans[trip_.first].stamp_ns());
  const auto jitter = std::uniform_int_distribution<std::int64_t>(
      0, std::chrono::nanoseconds(fleet_.options.arrival_jitter).count())(random_);
  const Clock::time_point due =
      *trip_.begin +
      std::chrono::nanoseconds(std::llround(recorded_ns / fleet_.options.pace) + jitter);
  trip_.last_due = std::max({due, trip_.last_due, trip_.stalled_until});
  At(trip_.last_due, &Vehicle::SendDue);
}

void Vehicle::SendDue() {
  if (Clock::now() < trip_.stalled_until) return At(trip_.stalled_until, &Vehicle::SendDue);
  if (!IsEnding()) SendNext(std::max(trip_.last_due, trip_.stalled_until));
  PlanNextScan();
}

void Vehicle::SendNext(Clock::time_point due) {
  const FaultProfile& faults = fleet_.options.faults;
  const Outgoing outgoing{.expected = {.scan = &route_.scans[trip_.next++]}, .due = due};
  const bool is_last = trip_.next >= route_.scans.size();
  if (!trip_.held && !is_last && Chance(faults.reorder_share)) {
    trip_.held = outgoing;
    return;
  }
  Push(outgoing);
  if (Chance(faults.duplicate_share)) {
    Outgoing again = outgoing;
    again.expected.sending = Sending::kDuplicate;
    Push(again);
  }
  if (trip_.held) {
    trip_.held->expected.sending = Sending::kReordered;
    Push(*std::exchange(trip_.held, std::nullopt));
  }
}

void Vehicle::Push(const Outgoing& outgoing) {
  if (outbox_.size() - sent_count_ >= kMaxWaiting) {
    // Nobody can send faster than an answer is read.
    if (!is_slow_reader_) fleet_.recorder.AddSkipped();
    return;
  }
  outbox_.push_back(outgoing);
  if (HasStream()) connection_->WriteOn();
}

void Vehicle::Flush() {
  if (trip_.held) Push(*std::exchange(trip_.held, std::nullopt));
  if (HasStream()) connection_->WriteOn();  // it may have to close
}

// ---- The stream

Fill Vehicle::FillRequest(v1::LocalizeRequest* request) {
  if (!WasOpened(stream_) || stream_ == StreamState::kCut) return Fill::kNothingYet;
  if (sent_count_ < outbox_.size()) {
    if (sent_count_ >= window_) return Fill::kNothingYet;
    *request->mutable_scan() = *outbox_[sent_count_++].expected.scan;
    return Fill::kRequest;
  }
  const bool is_over = IsEnding() || (trip_.next >= route_.scans.size() && !trip_.held);
  if (!is_over) return Fill::kNothingYet;
  if (stream_ == StreamState::kClosing) return Fill::kNothingMore;
  if (!outbox_.empty()) return Fill::kNothingYet;
  stream_ = Next(stream_, StreamEvent::kClose);
  request->mutable_close();
  return Fill::kRequest;
}

bool Vehicle::HasRoom() const {
  return !is_slow_reader_ || stream_ == StreamState::kCut || IsEnding() ||
         Clock::now() >= read_again_;
}

void Vehicle::Take(v1::LocalizeResponse response) {
  if (response.has_ending()) return;  // the status says the same
  if (response.has_opened()) {
    TakeOpened(response.opened());
  } else {
    TakeAnswer(response);
  }
  if (!is_slow_reader_ || IsEnding()) return;
  read_again_ = Clock::now() + fleet_.options.faults.slow_read_interval;
  At(read_again_, &Vehicle::ReadOn);
}

void Vehicle::ReadOn() {
  if (HasStream()) connection_->ReadOn();
}

void Vehicle::TakeOpened(const v1::SessionOpened& opened) {
  stream_ = Next(stream_, StreamEvent::kOpened);
  window_ = Window(opened);
  const bool is_new = trip_.resume_token.empty();
  trip_.resume_token = opened.resume_token();
  if (is_new) map_version_ = opened.map_version();
  if (is_new && trip_.begin) fleet_.recorder.AddRestarted();
  if (trip_.begin) return;
  trip_.is_resumable = !trip_.resume_token.empty();
  fleet_.recorder.AddOpened(Clock::now() - open_time_);
  trip_.begin = trip_.last_due = Clock::now();
  if (fleet_.options.faults.disconnects_per_min > 0.0) PlanDisconnect();
  if (fleet_.options.faults.stalls_per_min > 0.0) PlanStall();
  PlanNextScan();
}

void Vehicle::TakeAnswer(const v1::LocalizeResponse& answer) {
  // After a cut, as if it had been lost in transit: it will come again.
  if (stream_ == StreamState::kCut) return;
  if (sent_count_ == 0) {
    fleet_.recorder.AddViolation("an answer came when none was due");
    return connection_->Cancel();
  }
  const Outgoing answered = outbox_.front();
  if (const auto fault = FaultOf(answer, answered.expected, ExpectedVersion(answer))) {
    fleet_.recorder.AddViolation(*fault);
  }
  outbox_.pop_front();
  --sent_count_;
  Count(answer, answered);
  if (answer.has_result()) trip_.prior.Note(answer.result());
  const Clock::time_point now = Clock::now();
  if (last_answer_ && !is_slow_reader_) fleet_.recorder.AddGap(*last_answer_, now);
  last_answer_ = now;
  if (!fleet_.options.open_loop && outbox_.empty()) PlanNextScan();
}

/// A session that did not ask for a version may be moved to another one by whoever activates it;
/// what comes from memory may be from before.
std::int64_t Vehicle::ExpectedVersion(const v1::LocalizeResponse& answer) {
  if (trip_.asks_for_version || !answer.has_result()) return map_version_;
  const std::int64_t version = answer.result().map_version();
  if (answer.from_memory() || version == map_version_) return version;
  fleet_.recorder.AddMoved();
  return map_version_ = version;
}

void Vehicle::Count(const v1::LocalizeResponse& answer, const Outgoing& answered) {
  Recorder& recorder = fleet_.recorder;
  if (answered.expected.sending == Sending::kReordered && answer.has_rejected()) {
    return recorder.AddLateRefused();
  }
  if (answer.has_rejected()) return recorder.AddRejected(answer.rejected());
  if (answer.from_memory()) recorder.AddRepeated();
  if (answered.expected.sending == Sending::kDuplicate) return;
  recorder.AddAnswer(answer, Clock::now() - answered.due, !is_slow_reader_);
  const auto number = static_cast<std::size_t>(answered.expected.scan->sequence_number());
  if (number < route_.true_positions_m.size() && answer.result().pose().covariance_size() == 36) {
    const auto error = ErrorOf(answer.result(), route_.true_positions_m[number]);
    if (error) recorder.AddError(*error);
  }
}

// ---- The end of a stream

void Vehicle::OnEnd(const grpc::Status& status) {
  end_status_ = status;
  // The connection cannot go before this returns, and gRPC's threads should not open streams.
  At(Clock::now(), &Vehicle::AfterEnd);
}

void Vehicle::AfterEnd() {
  connection_.reset();
  const bool as_planned = end_status_->ok() && stream_ == StreamState::kClosing && outbox_.empty();
  const grpc::StatusCode code = end_status_->error_code();
  const bool cancelled = state_ == VehicleState::kCancelled;
  // A proxy may answer with a reset in place of NOT_FOUND.
  const bool is_refused =
      code == grpc::StatusCode::NOT_FOUND || (code == grpc::StatusCode::CANCELLED && !cancelled);
  const bool is_gone = is_refused && !trip_.resume_token.empty() && !WasOpened(stream_);
  if (!as_planned && !is_gone && !FollowsCut(stream_) && !cancelled) {
    fleet_.recorder.AddBroken(TextOf(*end_status_));
  }
  if (as_planned || cancelled) {
    if (trip_.begin) fleet_.recorder.AddEnded();
    LoseOutbox();
    last_answer_.reset();
    return EndOrBeginTrip(0);
  }
  // As the SDK does: what the server no longer has begins anew, from the last pose.
  if (is_gone) trip_.resume_token.clear();
  if (is_gone || MayGoOn()) {
    for (std::size_t i = 0; i < sent_count_; ++i) outbox_[i].expected.resent = true;
    const bool at_once = stream_ == StreamState::kCut || is_gone;
    At(Clock::now() + (at_once ? Clock::duration(0) : kResumeDelay), &Vehicle::OpenStream);
    return;
  }
  if (trip_.begin) fleet_.recorder.AddEnded();
  LoseOutbox();
  At(Clock::now() + kRetryDelay, &Vehicle::Restart);
}

/// Whether the session that was open can be resumed, or begun anew, after its stream has ended.
bool Vehicle::MayGoOn() const {
  return trip_.begin && trip_.is_resumable &&
         client::IsRetryable(client::FromGrpc(*end_status_), WasOpened(stream_));
}

void Vehicle::Restart() { EndOrBeginTrip(trip_.next < route_.scans.size() ? trip_.next : 0); }

void Vehicle::EndOrBeginTrip(std::size_t first) {
  state_ = Next(state_, VehicleEvent::kEnd);
  if (state_ != VehicleState::kDone) BeginTrip(first);
}

void Vehicle::LoseOutbox() {
  // What was never taken by the transport was not lost in transit, but nobody answered it either.
  fleet_.recorder.AddLost(std::ranges::count_if(outbox_, [](const Outgoing& outgoing) {
    return outgoing.expected.sending == Sending::kOnce;
  }));
  outbox_.clear();
  sent_count_ = 0;
}

// ---- What goes wrong on purpose

void Vehicle::PlanDisconnect() {
  At(Clock::now() + TimeToNext(fleet_.options.faults.disconnects_per_min), &Vehicle::Cut);
}

void Vehicle::Cut() {
  if (IsEnding()) return;
  if (HasStream() && stream_ == StreamState::kOpen) {
    stream_ = Next(stream_, StreamEvent::kCut);
    fleet_.recorder.AddDisconnect();
    if (link_.relay != nullptr) {
      link_.relay->Cut();
    } else {
      connection_->Cancel();
    }
  }
  PlanDisconnect();
}

void Vehicle::PlanStall() {
  At(Clock::now() + TimeToNext(fleet_.options.faults.stalls_per_min), &Vehicle::Stall);
}

void Vehicle::Stall() {
  if (IsEnding()) return;
  trip_.stalled_until = Clock::now() + fleet_.options.faults.stall_duration;
  fleet_.recorder.AddStall();
  PlanStall();
}

bool Vehicle::Chance(double share) {
  return share > 0.0 && std::uniform_real_distribution(0.0, 1.0)(random_) < share;
}

Vehicle::Clock::duration Vehicle::TimeToNext(double events_per_min) {
  const double minutes = std::exponential_distribution(events_per_min)(random_);
  return std::chrono::duration_cast<Clock::duration>(
      std::chrono::duration<double, std::ratio<60>>(minutes));
}

}  // namespace dcloc::load
