#pragma once

#include <chrono>
#include <string>

#include "client/cli/common/live_line.h"

namespace dcloc::cli {

/// A progress line on stderr for work in stages: the stage, its share that is done and the time
/// that it will still take.
class StageLine {
 public:
  void Update(const std::string& stage, double share);

 private:
  using Clock = std::chrono::steady_clock;

  LiveLine line_;
  std::string stage_;
  Clock::time_point begin_;
  Clock::time_point next_draw_;
};

}  // namespace dcloc::cli
