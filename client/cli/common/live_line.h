#pragma once

#include <string>

namespace dcloc::cli {

/// A line on stderr that is drawn over and over; nothing where stderr is no terminal. It is wiped
/// at the end.
class LiveLine {
 public:
  LiveLine();
  LiveLine(const LiveLine&) = delete;
  LiveLine& operator=(const LiveLine&) = delete;
  ~LiveLine();

  bool is_terminal() const { return is_terminal_; }
  void Show(const std::string& text) const;

 private:
  const bool is_terminal_;
};

}  // namespace dcloc::cli
