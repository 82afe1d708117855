#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <optional>

#include "core/localizer/localizer.h"

namespace dcloc::server {

/// Measures the stages of a scan: core reports when a stage begins, and this class reads the clock.
class StageTimer final : public StageListener {
 public:
  using Clock = std::chrono::steady_clock;

  void OnStageBegin(Stage stage) override {
    const Clock::time_point now = Clock::now();
    EndStage(now);
    stage_ = stage;
    stage_begin_ = now;
  }

  /// The last stage ends here.
  void End() { EndStage(Clock::now()); }

  /// Zero for a stage that did not run.
  std::chrono::nanoseconds duration(Stage stage) const {
    return durations_[static_cast<std::size_t>(stage)];
  }

 private:
  void EndStage(Clock::time_point now) {
    if (stage_) durations_[static_cast<std::size_t>(*stage_)] += now - stage_begin_;
    stage_.reset();
  }

  std::optional<Stage> stage_;
  Clock::time_point stage_begin_;
  std::array<std::chrono::nanoseconds, kStageNames.size()> durations_{};
};

}  // namespace dcloc::server
