#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

#include "server/base/within_memory.h"

namespace dcloc::server {

/// Calls a function periodically on a thread of its own, until it is destroyed.
class Ticker {
 public:
  Ticker(std::chrono::milliseconds interval, std::function<void()> tick)
      : thread_([this, interval, tick = std::move(tick)](const std::stop_token& stop) {
          std::unique_lock lock(mutex_);
          while (!stop.stop_requested()) {
            never_.wait_for(lock, stop, interval, [] { return false; });
            // One that gets no memory has its next turn.
            if (!stop.stop_requested()) WithinMemory(tick).IgnoreError();
          }
        }) {}

 private:
  std::mutex mutex_;
  std::condition_variable_any never_;
  std::jthread thread_;  ///< last: it uses the others
};

}  // namespace dcloc::server
