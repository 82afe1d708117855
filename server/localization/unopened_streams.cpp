#include "server/localization/unopened_streams.h"

#include <algorithm>

#include "absl/strings/str_format.h"
#include "server/base/status.h"

namespace dcloc::server {

std::optional<UnopenedStreams::Excess> UnopenedStreams::Add(LocalizeStream* stream,
                                                            const std::string& group,
                                                            const Bounds& bounds) {
  const auto own = groups_.try_emplace(group).first;
  place_of_[stream] = {own, own->second.insert(own->second.end(), stream)};
  if (bounds.group > 0 && static_cast<int>(own->second.size()) > bounds.group) {
    return TakeOldest(own, bounds.group, "max_unopened_stream_count_per_peer");
  }
  if (count() <= bounds.total) return std::nullopt;
  const auto largest = std::ranges::max_element(
      groups_, {}, [](const Groups::value_type& entry) { return entry.second.size(); });
  return TakeOldest(largest, bounds.total, "max_unopened_stream_count");
}

std::optional<UnopenedStreams::Excess> UnopenedStreams::Move(LocalizeStream* stream,
                                                             const std::string& group,
                                                             const Bounds& bounds) {
  if (!place_of_.contains(stream)) return std::nullopt;
  Remove(stream);
  return Add(stream, group, bounds);
}

void UnopenedStreams::Remove(LocalizeStream* stream) {
  const auto found = place_of_.find(stream);
  if (found == place_of_.end()) return;
  const Place place = found->second;
  place_of_.erase(found);
  place.group->second.erase(place.position);
  if (place.group->second.empty()) groups_.erase(place.group);
}

UnopenedStreams::Excess UnopenedStreams::TakeOldest(Groups::iterator group, int max,
                                                    const char* setting) {
  Excess excess{
      .stream = group->second.front(),
      .reason = absl::StrFormat("%d streams of %s wait for their open; %s is %d",
                                group->second.size(), Quoted(group->first), setting, max)};
  Remove(excess.stream);
  return excess;
}

}  // namespace dcloc::server
