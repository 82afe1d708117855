#include "client/sdk/session_engine.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/sdk/retry.h"
#include "client/sdk/status.h"

namespace dcloc::client {
namespace {

/// So many resets of attempts to resume a session mean that it is gone.
constexpr int kRefusingResetCount = 2;

}  // namespace

SessionEngine::SessionEngine(std::unique_ptr<v1::LocalizationService::Stub> stub,
                             v1::OpenSession open, SessionOptions options)
    : stub_(std::move(stub)),
      open_(std::move(open)),
      options_(std::move(options)),
      poses_(options_.pose) {
  if (options_.reconnect) {
    backoff_.emplace(options_.reconnect->initial_backoff, options_.reconnect->max_backoff);
  }
  thread_ = std::thread([this] { Run(); });
}

SessionEngine::~SessionEngine() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = Stop::kAbandoned;
  }
  Cancel();
  thread_.join();
  recorder_.End("its client let go of it");
}

absl::Status SessionEngine::WaitUntilOpen() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return first_opened_.has_value() || end_status_.has_value(); });
  return first_opened_ ? absl::OkStatus() : *end_status_;
}

/// OK while there is room, and scans and fixes are taken.
template <typename Predicate>
absl::Status SessionEngine::WaitForRoom(std::unique_lock<std::mutex>& lock, Predicate has_room) {
  if (options_.when_full == FullQueue::kBlock) {
    changed_.wait(lock, [&] { return has_room() || end_status_.has_value() || sending_closed_; });
  }
  if (sending_closed_) return absl::FailedPreconditionError("sending has been closed");
  if (end_status_) return absl::UnavailableError("the session has ended");
  return absl::OkStatus();
}

absl::Status SessionEngine::Send(v1::Scan scan, ScanNumber number) {
  std::unique_lock lock(mutex_);
  const auto has_room = [&] {
    return outbox_.waiting_scan_count() < options_.max_queued_scan_count;
  };
  if (absl::Status status = WaitForRoom(lock, has_room); !status.ok()) return status;
  if (!has_room()) {
    return absl::ResourceExhaustedError(
        absl::StrCat("the queue holds ", outbox_.waiting_scan_count(), " scans, its limit"));
  }
  if (number == ScanNumber::kNext) scan.set_sequence_number(next_sequence_number_);
  next_sequence_number_ = std::max(next_sequence_number_, scan.sequence_number() + 1);
  GiveVelocity(scan);
  outbox_.Push(std::move(scan));
  if (connection_ != nullptr) connection_->WriteOn();
  return absl::OkStatus();
}

absl::Status SessionEngine::SendFix(v1::PositionFix fix) {
  std::unique_lock lock(mutex_);
  const auto has_room = [&] {
    return !takes_fixes_ || outbox_.fix_count() < options_.max_unanswered_fix_count;
  };
  if (absl::Status status = WaitForRoom(lock, has_room); !status.ok()) return status;
  if (!takes_fixes_) {
    return absl::UnimplementedError("the server takes no position fixes; it is an older one");
  }
  if (!has_room()) {
    return absl::ResourceExhaustedError(absl::StrCat(
        outbox_.fix_count(), " position fixes are unanswered; max_unanswered_fix_count is ",
        options_.max_unanswered_fix_count));
  }
  outbox_.Push(std::move(fix));
  if (connection_ != nullptr) connection_->WriteOn();
  return absl::OkStatus();
}

void SessionEngine::CloseSending() {
  const std::lock_guard lock(mutex_);
  sending_closed_ = true;
  changed_.notify_all();
  if (connection_ != nullptr) connection_->WriteOn();
}

std::optional<SessionEngine::Answered> SessionEngine::TakeNext() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return !answers_.empty() || end_status_.has_value(); });
  if (answers_.empty()) return std::nullopt;
  Answered answered = std::move(answers_.front());
  answers_.pop_front();
  if (connection_ != nullptr) connection_->ReadOn();
  return answered;
}

std::optional<v1::LocalizeResponse> SessionEngine::Next() {
  std::optional<Answered> next;
  if (options_.record_file.empty()) {
    next = TakeNext();
  } else {
    // So that answers are recorded in the order in which they are taken.
    const std::lock_guard lock(record_mutex_);
    next = TakeNext();
    Record(next);
  }
  return next ? std::optional(std::move(next->answer)) : std::nullopt;
}

// ---- The recording, with its mutex held

absl::Status SessionEngine::StartRecording() {
  return recorder_.Begin(options_.record_file, open_, *first_opened_);
}

void SessionEngine::Record(const std::optional<Answered>& next) {
  if (!next) return recorder_.End(std::string(EndStatus().message()));
  if (next->gap != nullptr) return recorder_.End(next->gap);
  recorder_.Add(next->request, next->answer);
}

absl::Status SessionEngine::record_status() const {
  const std::lock_guard lock(record_mutex_);
  return recorder_.status();
}

void SessionEngine::Cancel() {
  const std::lock_guard lock(mutex_);
  if (stop_ == Stop::kNo) stop_ = Stop::kCancelled;
  changed_.notify_all();
  if (connection_ != nullptr) connection_->Cancel();
}

absl::Status SessionEngine::EndStatus() const {
  const std::lock_guard lock(mutex_);
  return end_status_.value_or(absl::FailedPreconditionError("the session has not ended"));
}

SessionStats SessionEngine::stats() const {
  const std::lock_guard lock(mutex_);
  return stats_;
}

// ---- The stream, with the mutex held

bool SessionEngine::HasRoom() const {
  return stop_ != Stop::kNo || options_.unread_answers == UnreadAnswers::kForgetOldest ||
         answers_.size() < options_.max_unread_answer_count;
}

void SessionEngine::Take(v1::LocalizeResponse response) {
  if (stop_ == Stop::kAbandoned) return;
  if (response.has_opened() != !opened_.has_value()) {
    GiveUp(absl::DataLossError("the server's first message must be `opened`, and no other one"));
  } else if (response.has_opened()) {
    TakeOpened(std::move(*response.mutable_opened()));
  } else if (response.has_ending()) {
    TakeEnding(response.ending());
  } else {
    TakeAnswer(std::move(response));
  }
  changed_.notify_all();
}

void SessionEngine::TakeOpened(v1::SessionOpened opened) {
  const bool first = !first_opened_;
  if (opened.epoch() > 0 && opened.epoch() < tickets_.epoch()) {
    return GiveUp(absl::DataLossError(absl::StrCat("the server opened epoch ", opened.epoch(),
                                                   ", which is stale: epoch ", tickets_.epoch(),
                                                   " has been open")));
  }
  const bool goes_on = opened.ticket_use() == v1::TICKET_USE_ACCEPTED;
  const bool begins_anew = !opened.resumed() && !goes_on;
  if (begins_anew && opened.ticket_use() != v1::TICKET_USE_UNSPECIFIED) {
    restart_reason_ = absl::NotFoundError(absl::StrCat("the server has not taken the ticket: ",
                                                       v1::TicketUse_Name(opened.ticket_use())));
  }
  tickets_.OnOpened(opened);
  // A session that goes on from a ticket may be resumed before it has caught up.
  catches_up_ = (goes_on || opened.resumed()) && opened.has_last_sequence_number();
  opened_ = opened;
  resume_token_ = opened.resume_token();
  resume_reset_count_ = 0;
  takes_fixes_ = opened.takes_position_fixes();
  if (!takes_fixes_) LoseFixes(outbox_.DropFixes());
  if (first) {
    first_opened_ = std::move(opened);
    return;
  }
  if (outbox_.empty()) failing_since_.reset();
  if (begins_anew) poses_.BeginAnew();
  ++(begins_anew ? stats_.restart_count : stats_.resume_count);
  if (goes_on) ++stats_.ticket_resume_count;
  Tell({.kind = begins_anew ? SessionEvent::Kind::kRestarted : SessionEvent::Kind::kResumed,
        .status = begins_anew ? restart_reason_ : absl::OkStatus(),
        .opened = std::move(opened)});
}

void SessionEngine::TakeEnding(const v1::SessionEnding& ending) {
  if (ending.reason() != v1::SESSION_END_REASON_DRAINING) return;  // the status says the same
  sending_ = Sending::kMoving;
  Tell({.kind = SessionEvent::Kind::kMoving,
        .status = absl::UnavailableError(ending.message()),
        .opened = {}});
}

void SessionEngine::TakeAnswer(v1::LocalizeResponse response) {
  absl::StatusOr<v1::LocalizeRequest> request = outbox_.TakeAnswer(response);
  if (!request.ok()) return GiveUp(request.status());
  failing_since_.reset();
  if (backoff_) backoff_->Reset();
  if (response.has_result()) {
    prior_.Note(response.result());
    poses_.AddAnswer(response.result());
  }
  if (request->has_scan()) tickets_.OnAnswered(request->scan(), response);
  response.clear_ticket();  // a secret
  // There is room but where the oldest are forgotten.
  if (answers_.size() >= options_.max_unread_answer_count &&
      options_.unread_answers == UnreadAnswers::kForgetOldest) {
    answers_.pop_front();
  }
  Answered& answered = answers_.emplace_back();
  answered.answer = std::move(response);
  if (options_.record_file.empty()) return;
  answered.request = *std::move(request);
  if (stats_.ticket_resume_count > 0) answered.gap = "the session went on at another server";
  if (stats_.restart_count > 0) answered.gap = "the session was lost, and begun anew";
  if (stats_.lost_fix_count > 0) answered.gap = "a position fix was lost with the connection";
}

/// They may have been used, and nobody knows.
void SessionEngine::LoseFixes(std::size_t count) {
  stats_.lost_fix_count += static_cast<std::int64_t>(count);
  if (count > 0) changed_.notify_all();
}

void SessionEngine::GiveUp(const absl::Status& status) {
  fault_.Update(status);
  connection_->Cancel();
}

void SessionEngine::OnEnd(const grpc::Status& status) {
  stream_status_ = FromGrpc(status);
  changed_.notify_all();
}

// ---- The session, on its thread

void SessionEngine::Run() {
  std::unique_lock lock(mutex_);
  while (true) {
    const absl::Status status = RunStream(lock);
    std::optional<absl::Status> end = Judge(status);
    DeliverEvents(lock);
    if (!end && !WaitForNextAttempt(lock)) end = absl::CancelledError("cancelled");
    if (end) {
      end_status_ = *std::move(end);
      changed_.notify_all();
      return;
    }
  }
}

absl::Status SessionEngine::RunStream(std::unique_lock<std::mutex>& lock) {
  opened_.reset();
  stream_status_.reset();
  sending_ = Sending::kOpen;
  catches_up_ = false;
  caught_up_count_ = 0;
  LoseFixes(outbox_.Rewind());
  connection_ = std::make_unique<Connection>(*stub_, mutex_, *this, OpenMessage());
  if (stop_ != Stop::kNo) connection_->Cancel();
  const Clock::time_point deadline = Clock::now() + options_.open_timeout;
  absl::Status timeout;
  while (!stream_status_) {
    DeliverEvents(lock);
    const auto woken = [&] { return stream_status_.has_value() || !events_.empty(); };
    if (opened_ || !timeout.ok()) {
      changed_.wait(lock, woken);
    } else if (!changed_.wait_until(lock, deadline,
                                    [&] { return woken() || opened_.has_value(); })) {
      timeout = absl::DeadlineExceededError(absl::StrCat(
          "the server has not opened the session within ", options_.open_timeout.count(), " ms"));
      connection_->Cancel();
    }
  }
  connection_.reset();  // nothing touches it after OnEnd
  return timeout.ok() ? *stream_status_ : timeout;
}

/// What a stream's end means: the session's end with a status, or another attempt.
std::optional<absl::Status> SessionEngine::Judge(const absl::Status& status) {
  if (!fault_.ok()) return fault_;
  if (stop_ != Stop::kNo) return absl::CancelledError("cancelled");
  if (!first_opened_) {
    return status.ok() ? absl::InternalError("the server ended the stream without opening it")
                       : status;
  }
  if (sending_closed_ && outbox_.empty()) return absl::OkStatus();
  const bool resuming = !resume_token_.empty() && !opened_;
  const bool can_return = options_.reconnect && !first_opened_->resume_token().empty();
  if (resuming && IsRefusal(status)) {
    restart_reason_ = status;
    resume_token_.clear();
    backoff_->Reset();  // a server is there
  } else if (!can_return || !IsRetryable(status, opened_.has_value())) {
    return Unanswered(status);
  }
  const Clock::time_point now = Clock::now();
  if (!failing_since_) failing_since_ = now;
  if (now - *failing_since_ > options_.reconnect->give_up_after) {
    return absl::UnavailableError(absl::StrCat("gave up after ",
                                               options_.reconnect->give_up_after.count(),
                                               " ms without progress: ", status.message()));
  }
  if (opened_) {
    ++stats_.disconnect_count;
    Tell({.kind = SessionEvent::Kind::kDisconnected, .status = status, .opened = {}});
  }
  return std::nullopt;
}

/// Whether the session will not be resumed. HAProxy 2.6 loses a refusal that a reset follows, and
/// hands on the reset. One reset is also what a server or a proxy gives that is stopping.
bool SessionEngine::IsRefusal(const absl::Status& status) {
  if (absl::IsNotFound(status)) return true;
  return absl::IsCancelled(status) && ++resume_reset_count_ >= kRefusingResetCount;
}

/// An early OK is no good end.
absl::Status SessionEngine::Unanswered(absl::Status status) const {
  if (!status.ok() || outbox_.empty()) return status;
  return absl::UnavailableError(absl::StrCat("the server ended the session with ",
                                             outbox_.scan_count(), " scans unanswered and ",
                                             outbox_.fix_count(), " position fixes"));
}

/// False when the session was cancelled meanwhile.
bool SessionEngine::WaitForNextAttempt(std::unique_lock<std::mutex>& lock) {
  changed_.wait_for(lock, backoff_->Next(), [&] { return stop_ != Stop::kNo; });
  return stop_ == Stop::kNo;
}

void SessionEngine::Tell(SessionEvent event) {
  if (options_.on_event) events_.push_back(std::move(event));
}

void SessionEngine::DeliverEvents(std::unique_lock<std::mutex>& lock) {
  while (!events_.empty()) {
    const SessionEvent event = std::move(events_.front());
    events_.pop_front();
    lock.unlock();
    options_.on_event(event);
    lock.lock();
  }
}

}  // namespace dcloc::client
