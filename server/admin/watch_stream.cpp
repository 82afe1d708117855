#include "server/admin/watch_stream.h"

#include <utility>

namespace dcloc::server {
namespace {

constexpr std::size_t kMaxWaitingAnswers = 64;

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

/// Instead of the oldest one where too many wait; but its rig, which comes once, is not left out.
void WatchStream::Queue(v1::WatchSessionResponse message) {
  const std::lock_guard lock(mutex_);
  if (!is_open()) return;
  if (waiting_.size() >= kMaxWaitingAnswers) {
    if (waiting_.front().has_rig()) waiting_[1].mutable_rig()->Swap(waiting_[0].mutable_rig());
    waiting_.pop_front();
    ++missed_count_;
  }
  waiting_.push_back(std::move(message));
  Pump();
}

void WatchStream::OnWrite(v1::WatchSessionResponse& message) {
  // Some may have been missed before they came here.
  message.set_missed_answer_count(message.missed_answer_count() + missed_count_);
}

}  // namespace dcloc::server
