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
  v1::WatchSessionResponse message;
  convert::ToProto(answer, message.mutable_answer());
  Queue(std::move(message));
}

void WatchStream::OnFixAnswer(const FixAnswer& answer) {
  if (!takes_fix_answers_) return;
  v1::WatchSessionResponse message;
  convert::ToProto(answer, message.mutable_answer()->mutable_position_fix_answer());
  Queue(std::move(message));
}

void WatchStream::OnRelayed(v1::WatchSessionResponse message) { Queue(std::move(message)); }

/// Instead of the oldest one where too many wait.
void WatchStream::Queue(v1::WatchSessionResponse message) {
  const std::lock_guard lock(mutex_);
  if (!is_open()) return;
  if (waiting_.size() >= kMaxWaitingAnswers) {
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
