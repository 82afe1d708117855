#pragma once

#include <chrono>
#include <cstddef>
#include <string>

#include "client/cli/common/live_line.h"

namespace dcloc::cli {

/// A progress line on stderr for a long step, removed when the step ends. Does nothing if stderr is
/// not a terminal.
class Progress {
 public:
  Progress(std::string step, std::size_t total);
  /// Of a step that is told as a share.
  explicit Progress(std::string step);

  /// `done` of the total; drawn ten times a second at most.
  void Update(std::size_t done);
  /// `share` of the whole, [0, 1].
  void UpdateShare(double share);
  /// A line that stays, on stderr whatever it is.
  void Say(const std::string& text) const { line_.Say(text); }

 private:
  std::string step_;
  std::size_t total_;
  LiveLine line_;
  std::chrono::steady_clock::time_point next_draw_;
};

}  // namespace dcloc::cli
