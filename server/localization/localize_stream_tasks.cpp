// What a stream has done on the pools.
#include "server/localization/localize_stream.h"

#include <utility>

#include "server/base/status.h"
#include "server/base/within_memory.h"

namespace dcloc::server {

absl::Status LocalizeStream::Authorize() {
  absl::StatusOr<Principal> principal =
      host_.storage.access.Authorize(*context_, v1::LocalizeRequest::descriptor());
  if (!principal.ok()) return principal.status();
  keeper_.OnAdmitted(*this, *principal);
  const std::lock_guard lock(mutex_);
  principal_ = *std::move(principal);
  return absl::OkStatus();
}

void LocalizeStream::CheckCaller() {
  const absl::Status status = WithinMemory([this] { return Authorize(); });
  if (!status.ok()) return Fail(ToGrpc(status));
  {
    const std::lock_guard lock(mutex_);
    task_under_way_ = Task::kNone;
    Take(StreamEvent::kAdmitted);
    if (state_ == StreamState::kOpening) {
      peer_wait_.Begin(std::chrono::milliseconds(host_.storage.limits.open_timeout_ms));
    }
  }
  Pump();
}

void LocalizeStream::Open() {
  const absl::Status status = WithinMemory([this] {
    AttachSession(host_, *context_, principal_, ring_.to_answer().request, shared_from_this(),
                  [self = shared_from_this()](absl::StatusOr<AttachedSession> attached) {
                    attached.ok() ? self->Opened(*std::move(attached))
                                  : self->Fail(ToGrpc(attached.status()));
                  });
  });
  if (!status.ok()) Fail(ToGrpc(status));
}

void LocalizeStream::Opened(AttachedSession attached) {
  absl::Status status;
  {
    const std::lock_guard lock(mutex_);
    task_under_way_ = Task::kNone;
    WithinMemory([&] {
      host_.sessions.context.metrics.ObserveOpen(grpc::StatusCode::OK, attached.resumed);
    }).IgnoreError();
    if (Take(StreamEvent::kOpened) == StreamAction::kAttachSession) {
      session_ = attached.session;
      status = FillWithinMemory(&ring_.to_answer().response, [&] { Attach(attached); });
    }
    if (!status.ok()) TakeStatus(StreamEvent::kFailed, ToGrpc(status));
    attached.session.reset();  // before the stream can end
  }
  Pump();
}

void LocalizeStream::Attach(const AttachedSession& attached) {
  const SessionDescription& description = attached.session->info()->description;
  terms_ = {.resumable = description.resumable(),
            .drops_oldest = description.drops_oldest,
            .resumed = attached.resumed};
  convert::ToProto(attached.session->Describe(attached.resumed),
                   ring_.to_answer().response.mutable_opened());
  if (terms_.drops_oldest) ring_.Lengthen();
  ring_.OnAnswered();
}

void LocalizeStream::Fail(grpc::Status status) {
  {
    const std::lock_guard lock(mutex_);
    const bool refused = UsesContext();
    task_under_way_ = Task::kNone;
    if (refused) {
      const bool resumes = !ring_.to_answer().request.open().resume_token().empty();
      WithinMemory([&] {
        host_.sessions.context.metrics.ObserveOpen(status.error_code(), resumes);
      }).IgnoreError();
    }
    TakeStatus(StreamEvent::kFailed, std::move(status));
  }
  Pump();
}

void LocalizeStream::AnswerNext() {
  Slot* slot = nullptr;
  std::shared_ptr<Session> session;
  Handling handling = Handling::kAnswer;
  {
    const std::lock_guard lock(mutex_);
    if (!RulesOf(state_).answers) return;
    slot = &ring_.to_answer();
    handling = slot->handling;
    session = session_;
    task_under_way_ = Task::kScan;
  }
  const absl::Status status =
      FillWithinMemory(&slot->response, [&] { return Answer(*session, *slot, handling); });
  session.reset();  // before the stream can end
  if (!status.ok()) return Fail(ToGrpc(status));
  {
    const std::lock_guard lock(mutex_);
    task_under_way_ = Task::kNone;
    ring_.OnAnswered();
  }
  Pump();
}

absl::Status LocalizeStream::Answer(Session& session, Slot& slot, Handling handling) const {
  if (slot.request.has_position_fix()) {
    session.TakeFix(slot.request.position_fix(), [&slot](const FixAnswer& answer) {
      slot.response.Clear();
      convert::ToProto(answer, slot.response.mutable_position_fix_answer());
    });
    return absl::OkStatus();
  }
  if (!slot.request.has_scan()) {
    return absl::InvalidArgumentError(
        slot.request.has_open() ? "open came twice; a stream is one session"
                                : "message is missing; it must be a scan or a position_fix");
  }
  if (handling == Handling::kCatchUp &&
      session.IsToCatchUp(slot.request.scan().sequence_number())) {
    slot.handling = Handling::kSilent;
    session.CatchUp(slot.request.scan());
    return absl::OkStatus();
  }
  const auto reply = [&slot](const ScanAnswer& answer) {
    convert::ToProto(answer, &slot.response);
  };
  if (handling == Handling::kDrop) {
    session.AnswerDropped(slot.request.scan().sequence_number(), reply);
  } else {
    session.Answer(slot.request.scan(), slot.arrival, reply);
  }
  return absl::OkStatus();
}

}  // namespace dcloc::server
