#include "client/cli/common/live_line.h"

#include <unistd.h>

#include <cstdio>

#include "absl/strings/str_format.h"

namespace dcloc::cli {
namespace {

constexpr const char* kWipe = "\r\033[K";

}  // namespace

LiveLine::LiveLine() : is_terminal_(isatty(STDERR_FILENO) != 0) {}

LiveLine::~LiveLine() {
  if (is_terminal_) absl::FPrintF(stderr, "%s", kWipe);
}

void LiveLine::Show(const std::string& text) const {
  if (!is_terminal_) return;
  absl::FPrintF(stderr, "%s%s", kWipe, text);
  std::fflush(stderr);
}

void LiveLine::Say(const std::string& text) const {
  absl::FPrintF(stderr, "%s%s\n", is_terminal_ ? kWipe : "", text);
}

}  // namespace dcloc::cli
