#include "server/localization/localize_stream.h"

#include <grpcpp/server_context.h>

#include <utility>

#include "server/base/status.h"
#include "server/base/traceparent.h"

namespace dcloc::server {
namespace {

/// Answers of dropped scans that wait behind the one that is being localized.
constexpr int kDroppedSlots = 64;

}  // namespace

std::shared_ptr<LocalizeStream> LocalizeStream::Start(
    const SessionHost& host, grpc::CallbackServerContext* context,
    std::function<void(LocalizeStream*)> on_done) {
  std::shared_ptr<LocalizeStream> stream(new LocalizeStream(host, context, std::move(on_done)));
  stream->self_ = stream;
  stream->Pump();
  return stream;
}

LocalizeStream::LocalizeStream(const SessionHost& host, grpc::CallbackServerContext* context,
                               std::function<void(LocalizeStream*)> on_done)
    : host_(host),
      context_(context),
      on_done_(std::move(on_done)),
      slots_(static_cast<std::size_t>(host.max_pending_scan_count)) {}

void LocalizeStream::Announce(const v1::SessionEnding& ending) {
  {
    const std::lock_guard lock(mutex_);
    if (announcement_) return;
    *announcement_.emplace().mutable_ending() = ending;
  }
  Pump();
}

void LocalizeStream::End(grpc::Status status) {
  {
    const std::lock_guard lock(mutex_);
    if (over_) return;
    draining_ = over_ = true;
    final_status_ = std::move(status);
  }
  Pump();
}

void LocalizeStream::Displace(grpc::Status status) {
  std::shared_ptr<Session> taken;
  {
    const std::lock_guard lock(mutex_);
    taken = std::exchange(session_, nullptr);
    failed_ = over_ = true;
    final_status_ = std::move(status);
  }
  Pump();
}

void LocalizeStream::Abort() {
  const std::lock_guard lock(mutex_);
  if (!finished_) context_->TryCancel();
}

bool LocalizeStream::resumable() const {
  const std::lock_guard lock(mutex_);
  return resumable_;
}

void LocalizeStream::OnReadDone(bool ok) {
  {
    const std::lock_guard lock(mutex_);
    reading_ = false;
    if (!ok) {
      draining_ = true;
      if (!resumable_) over_ = true;
    } else if (session_ != nullptr && SlotAt(read_count_).request.has_close()) {
      draining_ = over_ = true;
    } else if (!finished_ && !failed_) {
      Slot& slot = SlotAt(read_count_);
      slot.arrival = Arrival::Now();
      slot.dropped = false;
      const bool opens = read_count_++ == 0;
      if (opens) {
        opening_ = true;
        // Nothing else is read until this is answered, so no order is lost by leaving the strand.
        host_.storage.pool.Post([self = shared_from_this()] { self->Open(); });
      } else {
        session_->strand().Post([self = shared_from_this()] { self->Process(); });
        if (drops_oldest_) DropOldest();
      }
    }
  }
  Pump();
}

void LocalizeStream::OnWriteDone(bool ok) {
  {
    const std::lock_guard lock(mutex_);
    writing_ = false;
    if (!std::exchange(announcing_, false)) ++written_count_;
    if (!ok) cancelled_ = true;
  }
  Pump();
}

void LocalizeStream::OnCancel() {
  {
    const std::lock_guard lock(mutex_);
    cancelled_ = true;
  }
  Pump();
}

void LocalizeStream::OnDone() {
  on_done_(this);
  const std::shared_ptr<LocalizeStream> last = std::move(self_);
}

void LocalizeStream::Pump() {
  std::unique_lock lock(mutex_);
  if (pumping_) return;  // who is in it looks again before leaving
  pumping_ = true;
  for (Step step = TakeStep(); step != Step::kNone; step = TakeStep()) {
    Slot& read_slot = SlotAt(read_count_);
    Slot& write_slot = SlotAt(written_count_);
    // Let go of before the client hears of the end, who may then delete the map.
    std::shared_ptr<Session> released =
        step == Step::kFinish ? std::exchange(session_, nullptr) : nullptr;
    // Of a new session the client has no token before it has heard that it is open.
    const bool keep = resumable_ && !over_ && (resumed_ || written_count_ > 0);
    const std::string reason = EndReason();
    const grpc::Status status =
        cancelled_ ? grpc::Status(grpc::StatusCode::CANCELLED, "cancelled") : final_status_;
    lock.unlock();
    if (released != nullptr) LetGo(*released, keep, reason);
    released.reset();
    if (step == Step::kRead) StartRead(&read_slot.request);
    if (step == Step::kWrite) StartWrite(&write_slot.response);
    if (step == Step::kAnnounce) StartWrite(&*announcement_);
    if (step == Step::kFinish) Finish(status);
    lock.lock();
  }
  pumping_ = false;
}

LocalizeStream::Step LocalizeStream::TakeStep() {
  if (finished_) return Step::kNone;
  const bool may_write = !writing_ && !cancelled_;
  if (may_write && announcement_ && !announced_ && resumable_ && written_count_ > 0) {
    writing_ = announcing_ = announced_ = true;
    return Step::kAnnounce;
  }
  if (may_write && written_count_ < answered_count_) {
    writing_ = true;
    return Step::kWrite;
  }
  if (ShouldFinish()) {
    finished_ = true;
    return Step::kFinish;
  }
  if (!reading_ && !draining_ && !failed_ && !cancelled_ && HasRoom()) {
    reading_ = true;
    return Step::kRead;
  }
  return Step::kNone;
}

bool LocalizeStream::ShouldFinish() const {
  if (writing_ || opening_) return false;
  if (cancelled_) return true;
  if (failed_) return written_count_ == answered_count_;
  return draining_ && written_count_ == read_count_;
}

bool LocalizeStream::HasRoom() const {
  // Before the session is open, one message; then as many as there are slots.
  if (answered_count_ == 0) return read_count_ == 0;
  return read_count_ - written_count_ < static_cast<std::int64_t>(slots_.size());
}

void LocalizeStream::DropOldest() {
  const std::int64_t first = answered_count_ + (processing_ ? 1 : 0);
  std::int64_t waiting = 0;
  for (std::int64_t i = first; i < read_count_; ++i) waiting += SlotAt(i).dropped ? 0 : 1;
  for (std::int64_t i = first; waiting > host_.max_pending_scan_count; ++i) {
    Slot& slot = SlotAt(i);
    if (slot.dropped) continue;
    slot.dropped = true;
    --waiting;
    v1::LocalizeRequest header;  // the columns' memory goes
    header.mutable_scan()->set_sequence_number(slot.request.scan().sequence_number());
    slot.request = std::move(header);
  }
}

void LocalizeStream::Open() {
  const v1::LocalizeRequest& request = slots_[0].request;
  if (!request.has_open()) {
    return Fail(grpc::Status(grpc::StatusCode::INVALID_ARGUMENT,
                             "open is missing; it must be the first message of a stream"));
  }
  absl::StatusOr<Caller> caller = Authorize(request.open());
  if (!caller.ok()) return Fail(ToGrpc(caller.status()));
  request.open().resume_token().empty() ? OpenNew(*std::move(caller)) : Resume(*caller);
}

absl::StatusOr<Caller> LocalizeStream::Authorize(const v1::OpenSession& open) const {
  absl::StatusOr<Principal> principal =
      host_.storage.access.Authorize(*context_, v1::LocalizeRequest::descriptor());
  if (!principal.ok()) return principal.status();
  if (absl::Status status = CheckVehicle(*principal, open.vehicle_id()); !status.ok()) {
    return status;
  }
  return Caller{.principal = *std::move(principal),
                .peer = context_->peer(),
                .trace_id = TraceIdOf(*context_),
                .permit = nullptr};
}

void LocalizeStream::OpenNew(Caller caller) {
  absl::StatusOr<std::shared_ptr<const SessionPermit>> permit =
      host_.usages.TakeSession(caller.principal);
  if (!permit.ok()) return Fail(ToGrpc(permit.status()));
  caller.permit = *std::move(permit);
  absl::StatusOr<std::shared_ptr<Session>> session =
      Session::Open(slots_[0].request.open(), caller, host_.sessions);
  absl::Status status = session.status();
  if (status.ok()) {
    status = host_.registry.Add((*session)->record(), *session, weak_from_this());
  }
  if (!status.ok()) return Fail(ToGrpc(status));
  // Others know it by now and may have posted to its strand.
  Strand& strand = (*session)->strand();
  strand.Post([self = shared_from_this(), session = *std::move(session)]() mutable {
    self->Opened(std::move(session), /*resumed=*/false);
  });
}

void LocalizeStream::Resume(const Caller& caller) {
  const v1::OpenSession& open = slots_[0].request.open();
  absl::StatusOr<std::shared_ptr<Session>> found =
      host_.registry.Find(open.resume_token(), caller.principal, open.vehicle_id());
  if (!found.ok()) return Fail(ToGrpc(found.status()));
  // On the strand, so that what the stream before has begun is done.
  Strand& strand = (*found)->strand();
  strand.Post([self = shared_from_this(), session = *std::move(found)]() mutable {
    const auto before = self->host_.registry.Attach(*session->record(), self);
    if (!before.ok()) return self->Fail(ToGrpc(before.status()));
    if (*before != nullptr) {
      (*before)->Displace(grpc::Status(grpc::StatusCode::ABORTED,
                                       "another stream presented the session's resume token"));
    }
    self->Opened(std::move(session), /*resumed=*/true);
  });
}

void LocalizeStream::Opened(std::shared_ptr<Session> session, bool resumed) {
  {
    const std::lock_guard lock(mutex_);
    opening_ = false;
    resumed_ = resumed;
    host_.sessions.metrics.ObserveOpen(grpc::StatusCode::OK, resumed);
    resumable_ = session->record()->description.resumable();
    drops_oldest_ = session->record()->description.drops_oldest;
    session->Describe(resumed, slots_[0].response.mutable_opened());
    if (drops_oldest_) slots_.resize(slots_.size() + kDroppedSlots);
    session_ = std::move(session);
    ++answered_count_;
  }
  Pump();
}

void LocalizeStream::Fail(grpc::Status status) {
  {
    const std::lock_guard lock(mutex_);
    if (std::exchange(opening_, false)) {
      const bool resumes = !slots_[0].request.open().resume_token().empty();
      host_.sessions.metrics.ObserveOpen(status.error_code(), resumes);
    }
    failed_ = over_ = true;
    final_status_ = std::move(status);
  }
  Pump();
}

void LocalizeStream::Process() {
  Slot* slot = nullptr;
  std::shared_ptr<Session> session;
  {
    const std::lock_guard lock(mutex_);
    if (failed_ || cancelled_ || finished_) return;
    slot = &SlotAt(answered_count_);
    session = session_;
    processing_ = true;
  }
  grpc::Status status = Answer(*session, *slot, slot->dropped);
  session.reset();  // before the stream can end
  if (!status.ok()) return Fail(std::move(status));
  {
    const std::lock_guard lock(mutex_);
    processing_ = false;
    ++answered_count_;
  }
  Pump();
}

grpc::Status LocalizeStream::Answer(Session& session, Slot& slot, bool dropped) const {
  if (!slot.request.has_scan()) {
    return grpc::Status(grpc::StatusCode::INVALID_ARGUMENT,
                        slot.request.has_open() ? "open came twice; a stream is one session"
                                                : "message is missing; it must be a scan");
  }
  if (dropped) {
    session.AnswerDropped(slot.request.scan().sequence_number(), &slot.response);
  } else {
    session.Answer(slot.request.scan(), slot.arrival, &slot.response);
  }
  return grpc::Status::OK;
}

std::string LocalizeStream::EndReason() const {
  if (!final_status_.ok()) return final_status_.error_message();
  return cancelled_ ? "its connection broke" : "its client closed it";
}

void LocalizeStream::LetGo(const Session& session, bool keep, const std::string& reason) const {
  if (keep) {
    host_.registry.Detach(*session.record(), *this);
  } else {
    host_.registry.Remove(*session.record(), *this, reason);
  }
}

}  // namespace dcloc::server
