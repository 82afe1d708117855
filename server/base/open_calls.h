#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>

namespace dcloc::server {

/// Counts the running calls, so that a shutdown can wait for them alone. gRPC's own shutdown also
/// waits for idle connections, whose clients may be asleep. Thread-safe.
class OpenCalls {
 public:
  /// Counts as a running call as long as it lives. A moved-from object counts as none.
  class Token {
   public:
    explicit Token(OpenCalls& calls);
    Token(Token&& other) noexcept;
    Token& operator=(Token&&) = delete;
    ~Token();

   private:
    OpenCalls* calls_;
  };

  /// Waits until no call runs, or until `deadline` if given.
  void WaitUntilNone();
  void WaitUntilNone(std::chrono::steady_clock::time_point deadline);

 private:
  std::mutex mutex_;
  std::condition_variable none_;
  int count_ = 0;
};

}  // namespace dcloc::server
