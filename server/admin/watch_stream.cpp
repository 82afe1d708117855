#include "server/admin/watch_stream.h"

namespace dcloc::server {
namespace {

constexpr std::size_t kMaxWaitingAnswers = 64;

}  // namespace

std::shared_ptr<WatchStream> WatchStream::Start(const StorageHost& host,
                                                grpc::CallbackServerContext* context) {
  return Hold(std::shared_ptr<WatchStream>(new WatchStream(host, context)));
}

void WatchStream::OnAnswer(const ScanAnswer& answer) {
  const std::lock_guard lock(mutex_);
  if (!is_open()) return;
  convert::ToProto(answer, Queue());
  Pump();
}

void WatchStream::OnFixAnswer(const FixAnswer& answer) {
  if (!takes_fix_answers_) return;
  const std::lock_guard lock(mutex_);
  if (!is_open()) return;
  convert::ToProto(answer, Queue()->mutable_position_fix_answer());
  Pump();
}

/// Room for one more answer, with the mutex held.
v1::LocalizeResponse* WatchStream::Queue() {
  if (waiting_.size() >= kMaxWaitingAnswers) {
    waiting_.pop_front();
    ++missed_count_;
  }
  return waiting_.emplace_back().mutable_answer();
}

void WatchStream::OnWrite(v1::WatchSessionResponse& message) {
  message.set_missed_answer_count(missed_count_);
}

}  // namespace dcloc::server
