#include "server/localization/localize_stream.h"

#include <utility>

#include "server/status.h"

namespace dcloc::server {

std::shared_ptr<LocalizeStream> LocalizeStream::Start(
    const SessionHost& host, std::string peer, std::function<void(LocalizeStream*)> on_done) {
  std::shared_ptr<LocalizeStream> stream(
      new LocalizeStream(host, std::move(peer), std::move(on_done)));
  stream->self_ = stream;
  stream->Pump();
  return stream;
}

LocalizeStream::LocalizeStream(const SessionHost& host, std::string peer,
                               std::function<void(LocalizeStream*)> on_done)
    : host_(host),
      peer_(std::move(peer)),
      on_done_(std::move(on_done)),
      slots_(static_cast<std::size_t>(host.max_pending_scan_count)),
      strand_(host.localization_pool) {}

void LocalizeStream::End(grpc::Status status) {
  {
    const std::lock_guard lock(mutex_);
    if (draining_ || failed_) return;
    draining_ = true;
    final_status_ = std::move(status);
  }
  Pump();
}

void LocalizeStream::OnReadDone(bool ok) {
  {
    const std::lock_guard lock(mutex_);
    reading_ = false;
    if (!ok) {
      draining_ = true;
    } else if (!finished_) {
      const bool opens = read_count_ == 0;
      SlotAt(read_count_++).arrival = std::chrono::steady_clock::now();
      auto process = [self = shared_from_this()] { self->Process(); };
      if (opens) {
        // Nothing else is read until this is answered, so no order is lost by leaving the strand.
        host_.storage.pool.Post(std::move(process));
      } else {
        strand_.Post(std::move(process));
      }
    }
  }
  Pump();
}

void LocalizeStream::OnWriteDone(bool ok) {
  {
    const std::lock_guard lock(mutex_);
    writing_ = false;
    ++written_count_;
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
    // A cancelled call's task may still run and use the session; else it goes before the client
    // hears of the end, who may then delete the map.
    const bool idle = failed_ || answered_count_ == read_count_;
    std::unique_ptr<Session> ended = step == Step::kFinish && idle ? std::move(session_) : nullptr;
    const grpc::Status status =
        cancelled_ ? grpc::Status(grpc::StatusCode::CANCELLED, "cancelled") : final_status_;
    lock.unlock();
    ended.reset();
    if (step == Step::kRead) StartRead(&read_slot.request);
    if (step == Step::kWrite) StartWrite(&write_slot.response);
    if (step == Step::kFinish) Finish(status);
    lock.lock();
  }
  pumping_ = false;
}

LocalizeStream::Step LocalizeStream::TakeStep() {
  if (finished_) return Step::kNone;
  if (!writing_ && !cancelled_ && written_count_ < answered_count_) {
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
  if (writing_) return false;
  if (cancelled_) return true;
  if (failed_) return written_count_ == answered_count_;
  return draining_ && written_count_ == read_count_;
}

bool LocalizeStream::HasRoom() const {
  // Before the session is open, one message; then as many as there are slots.
  if (answered_count_ == 0) return read_count_ == 0;
  return read_count_ - written_count_ < static_cast<std::int64_t>(slots_.size());
}

void LocalizeStream::Process() {
  Slot* slot = nullptr;
  {
    const std::lock_guard lock(mutex_);
    if (failed_ || cancelled_ || finished_) return;
    slot = &SlotAt(answered_count_);
  }
  grpc::Status status = Answer(*slot);
  {
    const std::lock_guard lock(mutex_);
    if (status.ok()) {
      ++answered_count_;
    } else {
      failed_ = true;
      final_status_ = std::move(status);
    }
  }
  Pump();
}

grpc::Status LocalizeStream::Answer(Slot& slot) {
  if (session_ == nullptr) return OpenSession(slot);
  if (!slot.request.has_scan()) {
    return grpc::Status(grpc::StatusCode::INVALID_ARGUMENT,
                        slot.request.has_open() ? "open came twice; a stream is one session"
                                                : "message is missing; it must be a scan");
  }
  session_->Answer(slot.request.scan(), slot.arrival, &slot.response);
  return grpc::Status::OK;
}

grpc::Status LocalizeStream::OpenSession(Slot& slot) {
  if (!slot.request.has_open()) {
    return grpc::Status(grpc::StatusCode::INVALID_ARGUMENT,
                        "open is missing; it must be the first message of a stream");
  }
  absl::StatusOr<std::unique_ptr<Session>> session = Session::Open(
      slot.request.open(), peer_, host_.storage.store, host_.registry, host_.create_matcher);
  if (!session.ok()) return ToGrpc(session.status());
  session_ = *std::move(session);
  session_->Describe(slot.response.mutable_opened());
  return grpc::Status::OK;
}

}  // namespace dcloc::server
