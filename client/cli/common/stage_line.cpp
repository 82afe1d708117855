#include "client/cli/common/stage_line.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace dcloc::cli {
namespace {

constexpr auto kStageDrawInterval = std::chrono::milliseconds(100);
constexpr double kMinShare = 0.02;  // before, the time left is a guess
constexpr double kMinElapsed_s = 2.0;

std::string TimeLeft(double seconds) {
  if (seconds < 90.0) return absl::StrFormat("%.0f s", seconds);
  return absl::StrFormat("%.0f min", seconds / 60.0);
}

}  // namespace

void StageLine::Update(const std::string& stage, double share) {
  if (!line_.is_terminal()) return;
  const Clock::time_point now = Clock::now();
  if (stage != stage_) {
    stage_ = stage;
    begin_ = now;
    next_draw_ = now;
  }
  if (now < next_draw_) return;
  next_draw_ = now + kStageDrawInterval;
  std::string text = absl::StrFormat("%s: %.0f %%", stage, 100.0 * share);
  const double elapsed_s = std::chrono::duration<double>(now - begin_).count();
  if (share >= kMinShare && elapsed_s >= kMinElapsed_s) {
    absl::StrAppend(&text, ", ", TimeLeft(elapsed_s * (1.0 - share) / share), " left");
  }
  line_.Show(text);
}

}  // namespace dcloc::cli
