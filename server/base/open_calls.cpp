#include "server/base/open_calls.h"

#include <utility>

namespace dcloc::server {

OpenCalls::Token::Token(OpenCalls& calls) : calls_(&calls) {
  const std::lock_guard lock(calls.mutex_);
  ++calls.count_;
}

OpenCalls::Token::Token(Token&& other) noexcept : calls_(std::exchange(other.calls_, nullptr)) {}

OpenCalls::Token::~Token() {
  if (calls_ == nullptr) return;
  const std::lock_guard lock(calls_->mutex_);
  if (--calls_->count_ == 0) calls_->none_.notify_all();
}

void OpenCalls::WaitUntilNone() {
  std::unique_lock lock(mutex_);
  none_.wait(lock, [this] { return count_ == 0; });
}

void OpenCalls::WaitUntilNone(std::chrono::steady_clock::time_point deadline) {
  std::unique_lock lock(mutex_);
  none_.wait_until(lock, deadline, [this] { return count_ == 0; });
}

}  // namespace dcloc::server
