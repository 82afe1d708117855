#include "client/load/scheduler.h"

namespace dcloc::load {

Scheduler::Scheduler() : thread_([this](const std::stop_token& stop) { Run(stop); }) {}

Scheduler::~Scheduler() = default;

void Scheduler::At(Clock::time_point time, std::function<void()> task) {
  bool is_first = false;
  {
    const std::lock_guard lock(mutex_);
    const auto entry = tasks_.emplace(std::pair(time, next_number_++), std::move(task)).first;
    is_first = entry == tasks_.begin();
  }
  if (is_first) changed_.notify_one();
}

void Scheduler::Run(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    if (tasks_.empty()) {
      changed_.wait(lock, stop, [&] { return !tasks_.empty(); });
      continue;
    }
    const Clock::time_point time = tasks_.begin()->first.first;
    if (Clock::now() < time) {
      changed_.wait_until(lock, stop, time,
                          [&] { return !tasks_.empty() && tasks_.begin()->first.first < time; });
      continue;
    }
    const std::function<void()> task = std::move(tasks_.begin()->second);
    tasks_.erase(tasks_.begin());
    lock.unlock();
    task();
    lock.lock();
  }
}

}  // namespace dcloc::load
