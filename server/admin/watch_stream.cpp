#include "server/admin/watch_stream.h"

#include <utility>

#include "server/base/status.h"

namespace dcloc::server {
namespace {

constexpr std::size_t kMaxWaiting = 64;

}  // namespace

std::shared_ptr<WatchStream> WatchStream::Start(OpenCalls& open_calls) {
  std::shared_ptr<WatchStream> stream(new WatchStream(open_calls));
  stream->self_ = stream;
  return stream;
}

void WatchStream::Begin(const absl::Status& status) {
  if (!status.ok()) End(ToGrpc(status));
  const std::lock_guard lock(mutex_);
  begun_ = true;
  // The watcher knows from then on that it misses nothing.
  if (status.ok() && !end_status_) StartSendInitialMetadata();
  Pump();
}

void WatchStream::OnAnswer(const ScanAnswer& answer) {
  const std::lock_guard lock(mutex_);
  if (end_status_) return;
  if (waiting_.size() >= kMaxWaiting) {
    waiting_.pop_front();
    ++missed_count_;
  }
  convert::ToProto(answer, waiting_.emplace_back().mutable_answer());
  Pump();
}

void WatchStream::End(const grpc::Status& status) {
  const std::lock_guard lock(mutex_);
  if (!end_status_ || !status.ok()) end_status_ = status;
  if (!status.ok()) waiting_.clear();
  Pump();
}

void WatchStream::OnWriteDone(bool ok) {
  const std::lock_guard lock(mutex_);
  writing_ = false;
  if (!ok && !end_status_) end_status_ = grpc::Status::CANCELLED;
  if (!ok) waiting_.clear();
  Pump();
}

void WatchStream::OnDone() { const std::shared_ptr<WatchStream> last = std::move(self_); }

void WatchStream::Pump() {
  if (!begun_ || writing_ || finished_) return;
  if (!waiting_.empty()) {
    response_ = std::move(waiting_.front());
    waiting_.pop_front();
    response_.set_missed_answer_count(missed_count_);
    writing_ = true;
    StartWrite(&response_);
  } else if (end_status_) {
    finished_ = true;
    Finish(*end_status_);
  }
}

}  // namespace dcloc::server
