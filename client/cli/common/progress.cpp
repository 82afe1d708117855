#include "client/cli/common/progress.h"

#include <utility>

#include "absl/strings/str_format.h"

namespace dcloc::cli {
namespace {

constexpr auto kDrawInterval = std::chrono::milliseconds(100);
constexpr std::size_t kShareSteps = 1000;  // what is shown is a percentage

}  // namespace

Progress::Progress(std::string step, std::size_t total) : step_(std::move(step)), total_(total) {}

Progress::Progress(std::string step) : Progress(std::move(step), kShareSteps) {}

void Progress::Update(std::size_t done) {
  const auto now = std::chrono::steady_clock::now();
  if (!line_.is_terminal() || now < next_draw_) return;
  next_draw_ = now + kDrawInterval;
  const double percent =
      total_ == 0 ? 100.0 : 100.0 * static_cast<double>(done) / static_cast<double>(total_);
  line_.Show(absl::StrFormat("%s: %.0f %%", step_, percent));
}

void Progress::UpdateShare(double share) {
  Update(static_cast<std::size_t>(share * static_cast<double>(total_)));
}

}  // namespace dcloc::cli
