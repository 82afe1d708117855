#include "server/sessions/recording_subscriber.h"

namespace dcloc::server {

void RecordingRequests::Add(absl::string_view tenant, absl::string_view vehicle_id,
                            const std::shared_ptr<RecordingSubscriber>& subscriber) {
  const std::lock_guard lock(mutex_);
  // Those who gave up do not pile up.
  for (auto& [key, subscribers] : waiting_) {
    std::erase_if(subscribers, [](const auto& waiting) { return waiting.expired(); });
  }
  std::erase_if(waiting_, [](const auto& entry) { return entry.second.empty(); });
  waiting_[Key(tenant, vehicle_id)].push_back(subscriber);
  has_any_ = true;
}

void RecordingRequests::Forget(const RecordingSubscriber& subscriber) {
  const std::lock_guard lock(mutex_);
  for (auto& [key, subscribers] : waiting_) {
    std::erase_if(subscribers,
                  [&](const auto& waiting) { return waiting.lock().get() == &subscriber; });
  }
  std::erase_if(waiting_, [](const auto& entry) { return entry.second.empty(); });
  has_any_ = !waiting_.empty();
}

std::shared_ptr<RecordingSubscriber> RecordingRequests::Take(absl::string_view tenant,
                                                             absl::string_view vehicle_id) {
  if (!has_any_) return nullptr;
  const std::lock_guard lock(mutex_);
  const auto found = waiting_.find(Key(tenant, vehicle_id));
  if (found == waiting_.end()) return nullptr;
  std::shared_ptr<RecordingSubscriber> subscriber;
  while (subscriber == nullptr && !found->second.empty()) {
    subscriber = found->second.front().lock();
    found->second.pop_front();
  }
  if (found->second.empty()) waiting_.erase(found);
  has_any_ = !waiting_.empty();
  return subscriber;
}

}  // namespace dcloc::server
