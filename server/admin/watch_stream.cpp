#include "server/admin/watch_stream.h"

#include <utility>

namespace dcloc::server {
namespace {

constexpr std::size_t kMaxWaitingAnswers = 64;
constexpr std::size_t kMaxWaiting_bytes = 1 << 20;  ///< scans may be large

}  // namespace

std::shared_ptr<WatchStream> WatchStream::Start(const RpcContext& host,
                                                grpc::CallbackServerContext* context) {
  return Hold(std::shared_ptr<WatchStream>(new WatchStream(host, context)));
}

void WatchStream::OnAnswer(const ScanAnswer& answer, const v1::Scan* scan) {
  const bool shows_scan = rig_ && scan != nullptr;
  const bool is_queued = FillAndQueue([&](v1::WatchSessionResponse& message) {
    convert::ToProto(answer, message.mutable_answer());
    if (!shows_scan) return;
    *message.mutable_scan() = *scan;
    if (!rig_is_queued_) *message.mutable_rig() = *rig_;
  });
  if (shows_scan && is_queued) rig_is_queued_ = true;
}

void WatchStream::OnFixAnswer(const FixAnswer& answer) {
  if (!takes_fix_answers_) return;
  FillAndQueue([&](v1::WatchSessionResponse& message) {
    convert::ToProto(answer, message.mutable_answer()->mutable_position_fix_answer());
  });
}

/// One that gets no memory is missed; false then.
template <typename Fill>
bool WatchStream::FillAndQueue(Fill fill) {
  v1::WatchSessionResponse message;
  absl::Status queued = FillWithinMemory(&message, [&] { fill(message); });
  if (queued.ok()) queued = WithinMemory([&] { Queue(std::move(message)); });
  if (queued.ok()) return true;
  const std::lock_guard lock(mutex_);
  ++missed_count_;
  return false;
}

void WatchStream::OnRelayed(v1::WatchSessionResponse message) { Queue(std::move(message)); }

/// Instead of the oldest ones where too much waits.
void WatchStream::Queue(v1::WatchSessionResponse message) {
  const std::lock_guard lock(mutex_);
  if (!is_open()) return;
  const std::size_t size_bytes = message.ByteSizeLong();
  waiting_.push_back(std::move(message));
  waiting_bytes_ += size_bytes;
  while (waiting_.size() > 1 &&
         (waiting_.size() > kMaxWaitingAnswers || waiting_bytes_ > kMaxWaiting_bytes)) {
    DropOldest();
  }
  Pump();
}

/// Not its rig, which comes once.
void WatchStream::DropOldest() {
  v1::WatchSessionResponse& oldest = waiting_[0];
  if (oldest.has_rig()) {
    *waiting_[1].mutable_rig() = std::move(*oldest.mutable_rig());
    oldest.clear_rig();
  }
  waiting_bytes_ -= oldest.ByteSizeLong();
  waiting_.pop_front();
  ++missed_count_;
}

void WatchStream::OnWrite(v1::WatchSessionResponse& message) {
  waiting_bytes_ -= message.ByteSizeLong();
  // Some may have been missed before they came here.
  message.set_missed_answer_count(message.missed_answer_count() + missed_count_);
}

}  // namespace dcloc::server
