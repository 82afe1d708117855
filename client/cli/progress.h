#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace dcloc::cli {

/// A line on stderr that says how far a long step is; nothing where stderr is no terminal. The line
/// is wiped when the step ends.
class Progress {
 public:
  Progress(std::string step, std::size_t total);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress();

  /// `done` of the total; drawn ten times a second at most.
  void Update(std::size_t done);

 private:
  std::string step_;
  std::size_t total_;
  bool is_terminal_;
  std::chrono::steady_clock::time_point next_draw_;
};

}  // namespace dcloc::cli
