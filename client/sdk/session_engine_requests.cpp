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

/// To `PoseAt` the scan's; to a scan without one that of the ticks, which go with it.
void SessionEngine::GiveVelocity(v1::Scan& scan) {
  AddTicks(scan);
  if (scan.has_ego_velocity()) {
    // One that is not valid the server refuses.
    return poses_.AddVelocity(scan.stamp_ns(), scan.ego_velocity()).IgnoreError();
  }
  const std::lock_guard lock(motion_mutex_);
  if (auto velocity = motion_.VelocityAt(scan.stamp_ns())) {
    *scan.mutable_ego_velocity() = *std::move(velocity);
  }
}

void SessionEngine::AddTicks(v1::Scan& scan) {
  const std::lock_guard lock(motion_mutex_);
  constexpr std::int64_t kSetBack_ns = 1'000'000'000;
  if (scan.stamp_ns() < newest_scan_ns_ - kSetBack_ns) newest_scan_ns_ = 0;
  if (scan.stamp_ns() <= newest_scan_ns_) return;  // one that is late
  if (newest_scan_ns_ > 0 && !scan.has_motion()) {
    v1::MotionTicks ticks = motion_.TicksAround(newest_scan_ns_, scan.stamp_ns());
    if (ticks.stamp_offset_ns_size() > 1) *scan.mutable_motion() = std::move(ticks);
  }
  newest_scan_ns_ = scan.stamp_ns();
}

absl::Status SessionEngine::AddMotion(const MotionTick& tick) {
  std::optional<v1::EgoVelocity> velocity;
  {
    const std::lock_guard lock(motion_mutex_);
    if (absl::Status status = motion_.Add(tick); !status.ok()) return status;
    velocity = motion_.VelocityAt(tick.stamp_ns);
  }
  return velocity ? poses_.AddVelocity(tick.stamp_ns, *velocity) : absl::OkStatus();
}

}  // namespace dcloc::client
