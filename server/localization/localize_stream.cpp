#include "server/localization/localize_stream.h"

#include <grpcpp/server_context.h>

#include <utility>

#include "absl/strings/str_format.h"
#include "server/base/status.h"
#include "server/base/within_memory.h"
#include "server/rpc/wire.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {

std::shared_ptr<LocalizeStream> LocalizeStream::Create(const StreamContext& host,
                                                       grpc::CallbackServerContext* context,
                                                       StreamKeeper& keeper) {
  std::shared_ptr<LocalizeStream> stream(new LocalizeStream(host, context, keeper));
  host.storage.peer_bound_calls.Add(stream);
  return stream;
}

void LocalizeStream::Admit() {
  self_ = shared_from_this();
  const absl::Status posted = WithinMemory(
      [this] { host_.storage.pool.Post([self = shared_from_this()] { self->CheckCaller(); }); });
  if (!posted.ok()) Fail(ToGrpc(posted));
}

LocalizeStream::LocalizeStream(const StreamContext& host, grpc::CallbackServerContext* context,
                               StreamKeeper& keeper)
    : host_(host), context_(context), keeper_(keeper), ring_(host.max_pending_scan_count) {}

// ---- What happens to it

void LocalizeStream::Announce(const v1::SessionEnding& ending) {
  {
    const std::lock_guard lock(mutex_);
    if (announcement_ != Announcement::kNone) return;
    // Without memory nothing is announced; the session ends all the same.
    if (FillWithinMemory(&announced_, [&] { *announced_.mutable_ending() = ending; }).ok()) {
      announcement_ = Announcement::kWaiting;
    }
  }
  Pump();
}

void LocalizeStream::End(grpc::Status status) {
  {
    const std::lock_guard lock(mutex_);
    TakeStatus(StreamEvent::kEnded, std::move(status));
  }
  Pump();
}

void LocalizeStream::Displace(grpc::Status status) {
  std::shared_ptr<Session> taken;
  {
    const std::lock_guard lock(mutex_);
    taken = std::exchange(session_, nullptr);
    TakeStatus(StreamEvent::kFailed, std::move(status));
  }
  Pump();
}

void LocalizeStream::Abort() {
  const std::lock_guard lock(mutex_);
  if (state_ != StreamState::kFinished) context_->TryCancel();
}

void LocalizeStream::CheckPeer(PeerWait::Clock::time_point now) {
  {
    const std::lock_guard lock(mutex_);
    if (state_ == StreamState::kFinished || !peer_wait_.TakeOverdue(now)) return;
    PeerFaultCounts& faults = host_.storage.peer_bound_calls.faults();
    if (state_ != StreamState::kOpening) {
      ++faults.not_reading;
      spdlog::warn("stream cut off peer={} reason=\"its answers are not read\"", context_->peer());
      return context_->TryCancel();
    }
    ++faults.not_sending;
    TakeStatus(StreamEvent::kEnded, ToGrpc(WithinMemory([this] {
                 return absl::DeadlineExceededError(
                     absl::StrFormat("open did not come within open_timeout_ms, which is %d",
                                     host_.storage.limits.open_timeout_ms.load()));
               })));
  }
  Pump();
}

bool LocalizeStream::resumable() const {
  const std::lock_guard lock(mutex_);
  return terms_.resumable;
}

void LocalizeStream::OnReadDone(bool ok) {
  // The slot is the read's alone until it is done.
  absl::Status taken;
  if (ok) {
    incoming_bytes_ = incoming_.Length();
    taken = ParseMessage(&incoming_, &ring_.to_read().request);
  }
  bool is_first = false;
  {
    const std::lock_guard lock(mutex_);
    read_under_way_ = false;
    is_first = ring_.none_read();
    if (is_first) peer_wait_.End();
    if (taken.ok()) taken = WithinMemory([this, ok] { TakeRead(ok); });
    if (!taken.ok()) TakeStatus(StreamEvent::kFailed, ToGrpc(taken));
  }
  if (is_first) keeper_.OnFirstMessage(*this);
  Pump();
}

void LocalizeStream::TakeRead(bool ok) {
  const StreamAction action = Take(EventOfRead(ok));
  if (action == StreamAction::kOpenSession) {
    ring_.OnRead(incoming_bytes_);
    // Nothing else is read until this is answered, so no order is lost by leaving the strand.
    host_.storage.pool.Post([self = shared_from_this()] { self->Open(); });
    task_under_way_ = Task::kOpening;
  } else if (action == StreamAction::kQueueScan) {
    QueueScan();
  }
}

void LocalizeStream::OnWriteDone(bool ok) {
  {
    const std::lock_guard lock(mutex_);
    peer_wait_.End();
    if (std::exchange(write_under_way_, WriteUnderWay::kNone) == WriteUnderWay::kAnswer)
      ring_.OnWritten();
    if (!ok) Take(StreamEvent::kCancelled);
  }
  Pump();
}

void LocalizeStream::OnCancel() {
  {
    const std::lock_guard lock(mutex_);
    Take(StreamEvent::kCancelled);
  }
  Pump();
}

void LocalizeStream::OnDone() {
  keeper_.OnDone(*this);
  const std::shared_ptr<LocalizeStream> last = std::move(self_);
}

StreamAction LocalizeStream::Take(StreamEvent event) {
  const StreamTransition transition = Next(state_, event);
  state_ = transition.state;
  return transition.action;
}

void LocalizeStream::TakeStatus(StreamEvent event, grpc::Status status) {
  if (Take(event) == StreamAction::kTakeStatus) final_status_ = std::move(status);
}

StreamEvent LocalizeStream::EventOfRead(bool ok) {
  if (!ok) return terms_.resumable ? StreamEvent::kHalfClosed : StreamEvent::kClosed;
  if (ring_.none_read()) return StreamEvent::kFirstRead;
  const bool closes = ring_.to_read().request.has_close();
  return closes ? StreamEvent::kClosed : StreamEvent::kScanRead;
}

void LocalizeStream::QueueScan() {
  ring_.OnRead(incoming_bytes_);
  session_->strand().Post([self = shared_from_this()] { self->AnswerNext(); });
  Slot& slot = ring_.newest_read();
  if (slot.request.has_scan() && session_->MayCatchUp(slot.request.scan().sequence_number())) {
    slot.handling = Handling::kCatchUp;
  } else if (terms_.drops_oldest) {
    ring_.DropOldest(task_under_way_ == Task::kScan ? 1 : 0);
  }
}

// ---- What it does next

void LocalizeStream::Pump() {
  std::unique_lock lock(mutex_);
  if (pump_under_way_) return;
  pump_under_way_ = true;
  for (Step step = TakeStep(); step != Step::kNone; step = TakeStep()) {
    v1::LocalizeResponse* const response =
        step == Step::kAnnounce ? &announced_ : &ring_.to_write().response;
    lock.unlock();
    if (step == Step::kRead) StartRead(&incoming_);
    if (step == Step::kWrite || step == Step::kAnnounce) Write(*response);
    if (step == Step::kFinish) FinishWith(*std::exchange(ending_, std::nullopt));
    lock.lock();
  }
  pump_under_way_ = false;
}

/// Without memory for its bytes the call is cancelled, and they are not written.
void LocalizeStream::Write(const v1::LocalizeResponse& response) {
  if (WithinMemory([&] { outgoing_ = SerializeMessage(response); }).ok()) {
    return StartWrite(&outgoing_);
  }
  context_->TryCancel();
  const std::lock_guard lock(mutex_);
  peer_wait_.End();
  write_under_way_ = WriteUnderWay::kNone;
  Take(StreamEvent::kCancelled);
}

LocalizeStream::Step LocalizeStream::TakeWrite() {
  if (!RulesOf(state_).writes || write_under_way_ != WriteUnderWay::kNone) return Step::kNone;
  ring_.PassSilent();
  const bool announces = AnnouncementIsDue();
  if (!announces && !ring_.has_answer_to_write()) return Step::kNone;
  peer_wait_.Begin(std::chrono::milliseconds(host_.storage.limits.peer_timeout_ms));
  write_under_way_ = announces ? WriteUnderWay::kAnnouncement : WriteUnderWay::kAnswer;
  if (announces) announcement_ = Announcement::kWritten;
  return announces ? Step::kAnnounce : Step::kWrite;
}

LocalizeStream::Step LocalizeStream::TakeStep() {
  if (const Step write = TakeWrite(); write != Step::kNone) return write;
  if (IsSettled()) {
    ending_ = Ending{.status = ToGrpc(OutOfMemory()), .session = std::exchange(session_, nullptr)};
    WithinMemory([this] { Describe(*ending_); }).IgnoreError();
    if (Take(StreamEvent::kSettled) == StreamAction::kFinish) return Step::kFinish;
  }
  if (RulesOf(state_).reads && !read_under_way_ && ring_.has_room()) {
    read_under_way_ = true;
    return Step::kRead;
  }
  return Step::kNone;
}

/// Only who can resume a session could do something about its end, and only once it is open.
bool LocalizeStream::AnnouncementIsDue() const {
  return announcement_ == Announcement::kWaiting && terms_.resumable && ring_.any_written();
}

/// The call may not end while a task has its context.
bool LocalizeStream::UsesContext() const {
  return task_under_way_ == Task::kAdmission || task_under_way_ == Task::kOpening;
}

bool LocalizeStream::IsSettled() const {
  if (write_under_way_ != WriteUnderWay::kNone || UsesContext()) return false;
  switch (RulesOf(state_).must_write) {
    case MustWrite::kEverything:
      return false;
    case MustWrite::kWhatWasRead:
      return ring_.all_read_is_written();
    case MustWrite::kWhatIsMade:
      return !ring_.has_answer_to_write();
    case MustWrite::kNothing:
      return true;
  }
  return false;
}

void LocalizeStream::Describe(Ending& ending) const {
  const bool cancelled = RulesOf(state_).must_write == MustWrite::kNothing;
  const char* const usual_reason = cancelled ? "its connection broke" : "its client closed it";
  // Of a new session the client has no token before it has heard that it is open.
  ending.keeps_session =
      RulesOf(state_).keeps_session && terms_.resumable && (terms_.resumed || ring_.any_written());
  ending.reason = final_status_.ok() ? usual_reason : final_status_.error_message();
  ending.status =
      cancelled ? grpc::Status(grpc::StatusCode::CANCELLED, "cancelled") : final_status_;
}

/// Lets go of the session before the client hears of the end, who may then delete the map.
void LocalizeStream::FinishWith(Ending ending) {
  if (ending.session != nullptr) {
    const SessionInfo& info = *ending.session->info();
    WithinMemory([&] {
      ending.keeps_session ? host_.registry.Detach(info, *this)
                           : host_.registry.Remove(info, *this, ending.reason);
    }).IgnoreError();
    ending.session.reset();
  }
  Finish(std::move(ending.status));  // a copy takes memory
}

}  // namespace dcloc::server
