#include "server/sessions/session_tap.h"

namespace dcloc::server {

void TapRequests::Add(absl::string_view tenant, absl::string_view vehicle_id,
                      const std::shared_ptr<SessionTap>& tap) {
  const std::lock_guard lock(mutex_);
  // Those who gave up do not pile up.
  for (auto& [key, taps] : waiting_) {
    std::erase_if(taps, [](const auto& waiting) { return waiting.expired(); });
  }
  std::erase_if(waiting_, [](const auto& entry) { return entry.second.empty(); });
  waiting_[Key(tenant, vehicle_id)].push_back(tap);
  has_any_ = true;
}

std::shared_ptr<SessionTap> TapRequests::Take(absl::string_view tenant,
                                              absl::string_view vehicle_id) {
  if (!has_any_) return nullptr;
  const std::lock_guard lock(mutex_);
  const auto found = waiting_.find(Key(tenant, vehicle_id));
  if (found == waiting_.end()) return nullptr;
  std::shared_ptr<SessionTap> tap;
  while (tap == nullptr && !found->second.empty()) {
    tap = found->second.front().lock();
    found->second.pop_front();
  }
  if (found->second.empty()) waiting_.erase(found);
  has_any_ = !waiting_.empty();
  return tap;
}

}  // namespace dcloc::server
