#include "server/maps/store/warm_maps.h"

#include <algorithm>

namespace dcloc::server {

void WarmMaps::Keep(const Key& key, std::shared_ptr<const void> map, std::int64_t size_bytes) {
  const auto known = std::ranges::find(entries_, key, &Entry::key);
  if (known != entries_.end()) Drop(known);
  if (size_bytes > max_bytes_) return;
  entries_.push_front({key, std::move(map), size_bytes});
  size_bytes_ += size_bytes;
  while (size_bytes_ > max_bytes_) Drop(std::prev(entries_.end()));
}

void WarmMaps::KeepOnly(absl::string_view map_name, std::int64_t version,
                        std::int64_t other_version) {
  for (auto entry = entries_.begin(); entry != entries_.end();) {
    const auto& [name, number] = entry->key;
    const bool drop = name == map_name && number != version && number != other_version;
    entry = drop ? Drop(entry) : std::next(entry);
  }
}

bool WarmMaps::Has(const Key& key) const {
  return std::ranges::find(entries_, key, &Entry::key) != entries_.end();
}

WarmMaps::Entries::iterator WarmMaps::Drop(Entries::iterator entry) {
  size_bytes_ -= entry->size_bytes;
  return entries_.erase(entry);
}

}  // namespace dcloc::server
