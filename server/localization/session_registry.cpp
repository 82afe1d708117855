#include "server/localization/session_registry.h"

#include <utility>

namespace dcloc::server {

std::shared_ptr<SessionRecord> SessionRegistry::Add(SessionDescription description) {
  auto record = std::make_shared<SessionRecord>();
  record->description = std::move(description);
  const std::lock_guard lock(mutex_);
  std::erase_if(records_, [](const auto& entry) { return entry.second.expired(); });
  records_[record->description.session_id] = record;
  return record;
}

std::vector<std::shared_ptr<const SessionRecord>> SessionRegistry::List(absl::string_view after_id,
                                                                        int limit) const {
  std::vector<std::shared_ptr<const SessionRecord>> list;
  const std::lock_guard lock(mutex_);
  for (auto entry = records_.upper_bound(after_id);
       entry != records_.end() && static_cast<int>(list.size()) < limit; ++entry) {
    if (auto record = entry->second.lock()) list.push_back(std::move(record));
  }
  return list;
}

int SessionRegistry::count() const {
  const std::lock_guard lock(mutex_);
  int count = 0;
  for (const auto& [id, record] : records_) count += record.expired() ? 0 : 1;
  return count;
}

}  // namespace dcloc::server
