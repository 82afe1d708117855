#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

namespace dcloc::load {

/// Runs tasks at their time, on one thread. Thread-safe; tasks may plan further ones.
class Scheduler {
 public:
  using Clock = std::chrono::steady_clock;

  Scheduler();
  /// Waits for the task that runs; what has not begun is dropped.
  ~Scheduler();
  Scheduler(const Scheduler&) = delete;
  Scheduler& operator=(const Scheduler&) = delete;

  /// Tasks of the same time run in the order in which they were given.
  void At(Clock::time_point time, std::function<void()> task);

 private:
  void Run(const std::stop_token& stop);

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::map<std::pair<Clock::time_point, std::int64_t>, std::function<void()>> tasks_;
  std::int64_t next_number_ = 0;
  std::jthread thread_;  ///< last: it uses the others
};

}  // namespace dcloc::load
