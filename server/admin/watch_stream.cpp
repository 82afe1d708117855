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

void WatchStream::OnAnswer(const ScanAnswer& answer) {
  const std::lock_guard lock(mutex_);
  if (!is_open()) return;
  convert::ToProto(answer, Queue()->mutable_answer());
  Pump();
}

void WatchStream::OnFixAnswer(const FixAnswer& answer) {
  if (!takes_fix_answers_) return;
  const std::lock_guard lock(mutex_);
  if (!is_open()) return;
  convert::ToProto(answer, Queue()->mutable_answer()->mutable_position_fix_answer());
  Pump();
}

void WatchStream::OnRelayed(v1::WatchSessionResponse message) {
  const std::lock_guard lock(mutex_);
  if (!is_open()) return;
  *Queue() = std::move(message);
  Pump();
}

/// Room for one more answer, with the mutex held.
v1::WatchSessionResponse* WatchStream::Queue() {
  if (waiting_.size() >= kMaxWaitingAnswers) {
    waiting_.pop_front();
    ++missed_count_;
  }
  return &waiting_.emplace_back();
}

void WatchStream::OnWrite(v1::WatchSessionResponse& message) {
  // Some may have been missed before they came here.
  message.set_missed_answer_count(message.missed_answer_count() + missed_count_);
}

}  // namespace dcloc::server
