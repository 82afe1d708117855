#include "server/maps/service/download_slots.h"

#include <utility>

#include "absl/strings/str_format.h"

namespace dcloc::server {
namespace {

absl::Status TooMany(const char* setting, int max) {
  return absl::ResourceExhaustedError(
      absl::StrFormat("%d downloads are under way, which is %s; try again later", max, setting));
}

}  // namespace

absl::StatusOr<std::shared_ptr<void>> DownloadSlots::Take(const std::string& caller,
                                                          const Bounds& bounds) {
  auto give_back = [counts = counts_, name = std::string(caller)](void*) {
    const std::lock_guard lock(counts->mutex);
    --counts->total;
    const auto found = counts->of_callers.find(name);
    if (--found->second == 0) counts->of_callers.erase(found);
  };
  {
    const std::lock_guard lock(counts_->mutex);
    if (counts_->total >= bounds.total) return TooMany("max_download_count", bounds.total);
    int& of_caller = counts_->of_callers[caller];
    if (of_caller >= bounds.caller) {
      // An entry that has just been made stays out.
      if (of_caller == 0) counts_->of_callers.erase(caller);
      return TooMany("max_download_count_per_caller", bounds.caller);
    }
    ++counts_->total;
    ++of_caller;
  }
  // Without memory for it, it gives back at once; so no lock is held.
  return std::shared_ptr<void>(counts_.get(), std::move(give_back));
}

int DownloadSlots::count() const {
  const std::lock_guard lock(counts_->mutex);
  return counts_->total;
}

}  // namespace dcloc::server
