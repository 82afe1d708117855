#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>

namespace dcloc::server {

/// Counts the calls that are under way, so that a shutdown can wait for them alone: gRPC's own also
/// waits for idle connections, whose clients may be asleep. Thread-safe.
class OpenCalls {
 public:
  /// A call under way, as long as it lives. Moved-from, it is none.
  class Token {
   public:
    explicit Token(OpenCalls& calls);
    Token(Token&& other) noexcept;
    Token& operator=(Token&&) = delete;
    ~Token();

   private:
    OpenCalls* calls_;
  };

  /// Waits until there is none, or until `deadline` where there is one.
  void WaitUntilNone();
  void WaitUntilNone(std::chrono::steady_clock::time_point deadline);

 private:
  std::mutex mutex_;
  std::condition_variable none_;
  int count_ = 0;
};

}  // namespace dcloc::server
