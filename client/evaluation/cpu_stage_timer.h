#pragma once

#include <time.h>

#include <array>
#include <chrono>
#include <optional>

#include "core/localizer/localizer.h"

namespace dcloc {

/// Measures the stages of one scan: made just before `Localize`, asked just after, by one thread.
/// It measures the thread's own processor time, so other programs on the machine do not count.
class CpuStageTimer final : public StageListener {
 public:
  using StageDurations = std::array<std::optional<double>, kStageNames.size()>;

  CpuStageTimer() : begin_(Clock::now()) {}

  void OnStageBegin(Stage stage) override {
    const auto now = Clock::now();
    EndStage(now);
    running_ = static_cast<std::size_t>(stage);
    stage_begin_ = now;
  }

  /// Ends the last stage and the whole.
  void Stop() {
    const auto now = Clock::now();
    EndStage(now);
    running_.reset();
    total_ms_ = Milliseconds(now - begin_);
  }

  const StageDurations& stage_ms() const { return stage_ms_; }
  double total_ms() const { return total_ms_; }

 private:
  struct Clock {
    using duration = std::chrono::nanoseconds;
    using time_point = std::chrono::time_point<Clock, duration>;

    static time_point now() {
      timespec time{};
      clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
      return time_point(std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec));
    }
  };

  static double Milliseconds(Clock::duration duration) {
    return std::chrono::duration<double, std::milli>(duration).count();
  }

  void EndStage(Clock::time_point now) {
    if (!running_.has_value()) return;
    auto& stage_ms = stage_ms_.at(*running_);
    stage_ms = stage_ms.value_or(0.0) + Milliseconds(now - stage_begin_);
  }

  Clock::time_point begin_;
  Clock::time_point stage_begin_;
  std::optional<std::size_t> running_;
  StageDurations stage_ms_;
  double total_ms_ = 0.0;
};

}  // namespace dcloc
