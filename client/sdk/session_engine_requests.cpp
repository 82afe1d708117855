// What a session's streams send.
#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "client/sdk/session_engine.h"

namespace dcloc::client {

v1::OpenSession SessionEngine::OpenMessage() const {
  v1::OpenSession open;
  if (!resume_token_.empty() && !tickets_.has_ticket()) {
    open.set_vehicle_id(open_.vehicle_id());
    open.set_resume_token(resume_token_);
    open.set_epoch(tickets_.epoch());
    return open;
  }
  open = open_;
  open.set_resume_token(resume_token_);
  open.set_resumable(options_.reconnect.has_value());
  const v1::LocalizeRequest* first = outbox_.Next();
  const std::int64_t stamp_ns = first == nullptr    ? 0
                                : first->has_scan() ? first->scan().stamp_ns()
                                                    : first->position_fix().stamp_ns();
  prior_.Apply(stamp_ns, &open);
  tickets_.Apply(&open);
  return open;
}

Connection::Fill SessionEngine::FillRequest(v1::LocalizeRequest* request) {
  if (!opened_) return Connection::Fill::kNothingYet;
  if (sending_ == Sending::kMoving) return Connection::Fill::kNothingMore;
  if (FillCatchUp(request)) return Connection::Fill::kRequest;
  const std::size_t window =
      opened_->answer_history_count() == 0
          ? options_.max_unanswered_scan_count
          : std::min(options_.max_unanswered_scan_count,
                     static_cast<std::size_t>(opened_->answer_history_count()));
  if (const v1::LocalizeRequest* next = outbox_.Next(); next != nullptr) {
    if (next->has_scan() && outbox_.sent_scan_count() >= window) {
      return Connection::Fill::kNothingYet;
    }
    if (next->has_scan() && opened_->has_last_sequence_number() &&
        next->scan().sequence_number() <= opened_->last_sequence_number()) {
      // The server knows it by its number.
      request->mutable_scan()->Clear();
      request->mutable_scan()->set_sequence_number(next->scan().sequence_number());
    } else {
      *request = *next;
    }
    outbox_.MarkSent();
    changed_.notify_all();
    return Connection::Fill::kRequest;
  }
  if (!sending_closed_) return Connection::Fill::kNothingYet;
  if (resume_token_.empty() || sending_ == Sending::kCloseSent)
    return Connection::Fill::kNothingMore;
  // Only now: until all is answered the session may have to be resumed.
  if (!outbox_.empty()) return Connection::Fill::kNothingYet;
  sending_ = Sending::kCloseSent;
  request->mutable_close();
  return Connection::Fill::kRequest;
}

bool SessionEngine::FillCatchUp(v1::LocalizeRequest* request) {
  if (!catches_up_) return false;
  const v1::Scan* scan = tickets_.Next(opened_->last_sequence_number(), &caught_up_count_);
  catches_up_ = scan != nullptr;
  if (catches_up_) *request->mutable_scan() = *scan;
  return catches_up_;
}

}  // namespace dcloc::client
