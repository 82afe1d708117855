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
      random_(fleet.options.seed * 1'000'003 + static_cast<std::uint64_t>(index)) {
  is_slow_reader_ = Chance(fleet.options.faults.slow_reader_share);
}

Vehicle::~Vehicle() = default;

void Vehicle::Start() {
  const std::lock_guard lock(mutex_);
  if (finishing_) {
    done_ = true;
    return;
  }
  // Anywhere on the route, so that vehicles of one route do not ask for the same all the time.
  BeginTrip(random_() % route_.scans.size());
}

void Vehicle::Finish() {
  const std::lock_guard lock(mutex_);
  finishing_ = true;
  if (last_answer_ && !is_slow_reader_) fleet_.recorder.AddGap(*last_answer_, Clock::now());
  Flush();
  ReadOn();
}

void Vehicle::Cancel() {
  const std::lock_guard lock(mutex_);
  finishing_ = cancelled_ = true;
  if (connection_ != nullptr && !end_status_) {
    connection_->Cancel();
  } else if (connection_ == nullptr && !done_) {
    LoseOutbox();
    done_ = true;
  }
}

bool Vehicle::done() const {
  const std::lock_guard lock(mutex_);
  return done_;
}

void Vehicle::At(Clock::time_point time, void (Vehicle::*action)()) {
  fleet_.scheduler.At(time, [this, action, trip = trip_] {
    const std::lock_guard lock(mutex_);
    if (trip == trip_ && !done_) (this->*action)();
  });
}

// ---- The trip

void Vehicle::BeginTrip(std::size_t first) {
  ++trip_;
  first_ = next_ = first;
  begin_.reset();
  held_.reset();
  resume_token_.clear();
  prior_ = {};
  stalled_until_ = {};
  OpenStream();
}

void Vehicle::OpenStream() {
  opened_.reset();
  end_status_.reset();
  cutting_ = close_sent_ = false;
  sent_count_ = 0;
  open_time_ = Clock::now();
  v1::OpenSession open = OpenMessage();
  if (resume_token_.empty()) asked_for_version_ = open.map_version() != 0;
  connection_ = std::make_unique<client::Connection>(*stub_, mutex_, *this, std::move(open));
}

v1::OpenSession Vehicle::OpenMessage() const {
  v1::OpenSession open;
  if (resume_token_.empty()) {
    open = route_.open(first_, static_cast<std::uint64_t>(index_ * 1000L + trip_));
    open.set_resumable(true);
    open.set_queue_policy(fleet_.options.queue_policy);
    const std::size_t next = std::min(next_, route_.scans.size() - 1);
    const v1::Scan& scan = outbox_.empty() ? route_.scans[next] : *outbox_.front().expected.scan;
    prior_.Apply(scan.stamp_ns(), &open);
  } else {
    open.set_resume_token(resume_token_);
  }
  open.set_vehicle_id(absl::StrFormat("load-%05d", index_));
  return open;
}

void Vehicle::PlanNextScan() {
  if (finishing_ || next_ >= route_.scans.size()) return Flush();
  if (!fleet_.options.open_loop) {
    while (outbox_.empty() && next_ < route_.scans.size()) SendNext(Clock::now());
    return;
  }
  const double recorded_ns =
      static_cast<double>(route_.scans[next_].stamp_ns() - route_.scans[first_].stamp_ns());
  const auto jitter = std::uniform_int_distribution<std::int64_t>(
      0, std::chrono::nanoseconds(fleet_.options.arrival_jitter).count())(random_);
  const Clock::time_point due =
      *begin_ + std::chrono::nanoseconds(std::llround(recorded_ns / fleet_.options.pace) + jitter);
  last_due_ = std::max({due, last_due_, stalled_until_});
  At(last_due_, &Vehicle::SendDue);
}

void Vehicle::SendDue() {
  if (Clock::now() < stalled_until_) return At(stalled_until_, &Vehicle::SendDue);
  if (!finishing_) SendNext(std::max(last_due_, stalled_until_));
  PlanNextScan();
}

void Vehicle::SendNext(Clock::time_point due) {
  const FaultProfile& faults = fleet_.options.faults;
  const Outgoing outgoing{.expected = {.scan = &route_.scans[next_++]}, .due = due};
  const bool is_last = next_ >= route_.scans.size();
  if (!held_ && !is_last && Chance(faults.reorder_share)) {
    held_ = outgoing;
    return;
  }
  Push(outgoing);
  if (Chance(faults.duplicate_share)) {
    Outgoing again = outgoing;
    again.expected.sending = Sending::kAgain;
    Push(again);
  }
  if (held_) {
    held_->expected.sending = Sending::kBehind;
    Push(*std::exchange(held_, std::nullopt));
  }
}

void Vehicle::Push(const Outgoing& outgoing) {
  if (outbox_.size() - sent_count_ >= kMaxWaiting) {
    // Nobody can send faster than an answer is read.
    if (!is_slow_reader_) fleet_.recorder.AddSkipped();
    return;
  }
  outbox_.push_back(outgoing);
  if (connection_ != nullptr && !end_status_) connection_->WriteOn();
}

void Vehicle::Flush() {
  if (held_) Push(*std::exchange(held_, std::nullopt));
  if (connection_ != nullptr && !end_status_) connection_->WriteOn();  // it may have to close
}

// ---- The stream

Fill Vehicle::FillRequest(v1::LocalizeRequest* request) {
  if (!opened_ || cutting_) return Fill::kNothingYet;
  if (sent_count_ < outbox_.size()) {
    if (sent_count_ >= Window(*opened_)) return Fill::kNothingYet;
    *request->mutable_scan() = *outbox_[sent_count_++].expected.scan;
    return Fill::kRequest;
  }
  const bool is_over = finishing_ || (next_ >= route_.scans.size() && !held_);
  if (!is_over) return Fill::kNothingYet;
  if (close_sent_) return Fill::kNothingMore;
  if (!outbox_.empty()) return Fill::kNothingYet;
  close_sent_ = true;
  request->mutable_close();
  return Fill::kRequest;
}

bool Vehicle::HasRoom() const {
  return !is_slow_reader_ || cutting_ || finishing_ || Clock::now() >= read_again_;
}

void Vehicle::Take(v1::LocalizeResponse response) {
  if (response.has_ending()) return;  // the status says the same
  if (response.has_opened()) {
    TakeOpened(response.opened());
  } else {
    TakeAnswer(response);
  }
  if (!is_slow_reader_ || finishing_) return;
  read_again_ = Clock::now() + fleet_.options.faults.slow_read_interval;
  At(read_again_, &Vehicle::ReadOn);
}

void Vehicle::ReadOn() {
  if (connection_ != nullptr && !end_status_) connection_->ReadOn();
}

void Vehicle::TakeOpened(const v1::SessionOpened& opened) {
  opened_ = opened;
  mending_ = false;
  const bool is_new = resume_token_.empty();
  resume_token_ = opened.resume_token();
  if (is_new) map_version_ = opened.map_version();
  if (is_new && begin_) fleet_.recorder.AddRestarted();
  if (begin_) return;
  is_kept_ = !resume_token_.empty();
  fleet_.recorder.AddOpened(Clock::now() - open_time_);
  begin_ = last_due_ = Clock::now();
  if (fleet_.options.faults.disconnects_per_min > 0.0) PlanDisconnect();
  if (fleet_.options.faults.stalls_per_min > 0.0) PlanStall();
  PlanNextScan();
}

void Vehicle::TakeAnswer(const v1::LocalizeResponse& answer) {
  if (cutting_) return;  // as if it had been lost on the way: it will come again
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
  if (answer.has_result()) prior_.Note(answer.result());
  const Clock::time_point now = Clock::now();
  if (last_answer_ && !is_slow_reader_) fleet_.recorder.AddGap(*last_answer_, now);
  last_answer_ = now;
  if (!fleet_.options.open_loop && outbox_.empty()) PlanNextScan();
}

/// A session that did not ask for a version may be moved to another one by whoever activates it;
/// what comes from memory may be from before.
std::int64_t Vehicle::ExpectedVersion(const v1::LocalizeResponse& answer) {
  if (asked_for_version_ || !answer.has_result()) return map_version_;
  const std::int64_t version = answer.result().map_version();
  if (answer.from_memory() || version == map_version_) return version;
  fleet_.recorder.AddMoved();
  return map_version_ = version;
}

void Vehicle::Count(const v1::LocalizeResponse& answer, const Outgoing& answered) {
  Recorder& recorder = fleet_.recorder;
  if (answered.expected.sending == Sending::kBehind && answer.has_rejected()) {
    return recorder.AddLateRefused();
  }
  if (answer.has_rejected()) return recorder.AddRejected(answer.rejected());
  if (answer.from_memory()) recorder.AddRepeated();
  if (answered.expected.sending == Sending::kAgain) return;
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
  const bool as_planned = end_status_->ok() && close_sent_ && outbox_.empty();
  const grpc::StatusCode code = end_status_->error_code();
  // A proxy may answer with a reset in place of NOT_FOUND.
  const bool is_refused =
      code == grpc::StatusCode::NOT_FOUND || (code == grpc::StatusCode::CANCELLED && !cancelled_);
  const bool is_gone = is_refused && !resume_token_.empty() && !opened_;
  if (!as_planned && !is_gone && !cutting_ && !mending_ && !cancelled_)
    fleet_.recorder.AddBroken(TextOf(*end_status_));
  if (as_planned || cancelled_) {
    if (begin_) fleet_.recorder.AddEnded();
    LoseOutbox();
    last_answer_.reset();
    if (finishing_) {
      done_ = true;
    } else {
      BeginTrip(0);
    }
    return;
  }
  // As the SDK does: what the server no longer has begins anew, from the last pose.
  if (is_gone) resume_token_.clear();
  if (is_gone || MayGoOn()) {
    for (std::size_t i = 0; i < sent_count_; ++i) outbox_[i].expected.resent = true;
    const bool at_once = cutting_ || is_gone;
    At(Clock::now() + (at_once ? Clock::duration(0) : kResumeDelay), &Vehicle::OpenStream);
    return;
  }
  if (begin_) fleet_.recorder.AddEnded();
  LoseOutbox();
  At(Clock::now() + kRetryDelay, &Vehicle::Restart);
}

/// Whether the session that was open can be resumed, or begun anew, after its stream has ended.
bool Vehicle::MayGoOn() const {
  return begin_ && is_kept_ && client::MayPass(client::FromGrpc(*end_status_), opened_.has_value());
}

void Vehicle::Restart() {
  if (finishing_) {
    done_ = true;
  } else {
    BeginTrip(next_ < route_.scans.size() ? next_ : 0);
  }
}

void Vehicle::LoseOutbox() {
  // What was never taken by the transport was not lost on the way, but nobody answered it either.
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
  if (finishing_) return;
  if (connection_ != nullptr && opened_ && !end_status_ && !close_sent_) {
    cutting_ = mending_ = true;
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
  if (finishing_) return;
  stalled_until_ = Clock::now() + fleet_.options.faults.stall_duration;
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
