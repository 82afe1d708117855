#include "client/cli/progress.h"

#include <unistd.h>

#include <cstdio>
#include <utility>

#include "absl/strings/str_format.h"

namespace dcloc::cli {
namespace {

constexpr auto kDrawInterval = std::chrono::milliseconds(100);
constexpr const char* kWipe = "\r\033[K";

}  // namespace

Progress::Progress(std::string step, std::size_t total)
    : step_(std::move(step)), total_(total), is_terminal_(isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() {
  if (is_terminal_) absl::FPrintF(stderr, "%s", kWipe);
}

void Progress::Update(std::size_t done) {
  const auto now = std::chrono::steady_clock::now();
  if (!is_terminal_ || now < next_draw_) return;
  next_draw_ = now + kDrawInterval;
  const double percent =
      total_ == 0 ? 100.0 : 100.0 * static_cast<double>(done) / static_cast<double>(total_);
  absl::FPrintF(stderr, "%s%s: %.0f %%", kWipe, step_, percent);
  std::fflush(stderr);
}

}  // namespace dcloc::cli
