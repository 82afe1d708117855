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
  v1::WatchSessionResponse message;
  convert::ToProto(answer, message.mutable_answer());
  if (rig_ && scan != nullptr) {
    *message.mutable_scan() = *scan;
    if (!std::exchange(rig_is_queued_, true)) *message.mutable_rig() = *rig_;
  }
  Queue(std::move(message));
}

void WatchStream::OnFixAnswer(const FixAnswer& answer) {
  if (!takes_fix_answers_) return;
  v1::WatchSessionResponse message;
  convert::ToProto(answer, message.mutable_answer()->mutable_position_fix_answer());
  Queue(std::move(message));
}

void WatchStream::OnRelayed(v1::WatchSessionResponse message) { Queue(std::move(message)); }

/// Instead of the oldest ones where too much waits.
void WatchStream::Queue(v1::WatchSessionResponse message) {
  const std::lock_guard lock(mutex_);
  if (!is_open()) return;
  waiting_bytes_ += message.ByteSizeLong();
  waiting_.push_back(std::move(message));
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
