#pragma once

#include <string>

namespace dcloc::cli {

/// A line on stderr that is redrawn in place, and removed at the end. Does nothing if stderr is not
/// a terminal.
class LiveLine {
 public:
  LiveLine();
  LiveLine(const LiveLine&) = delete;
  LiveLine& operator=(const LiveLine&) = delete;
  ~LiveLine();

  bool is_terminal() const { return is_terminal_; }
  void Show(const std::string& text) const;

  /// Prints a line that stays, on stderr whatever it is.
  void Say(const std::string& text) const;

 private:
  const bool is_terminal_;
};

}  // namespace dcloc::cli
