#include "client/sdk/pose/published_timeline.h"

#include <algorithm>

namespace dcloc::client {

void PublishedTimeline::Publish(const std::vector<Segment>& segments, TimelineHead head) {
  const std::uint64_t next = count_.load(std::memory_order_relaxed) + 1;
  Copy& copy = (*copies_)[next % kCopies];
  const std::size_t count = std::min(segments.size(), kMaxSegments);
  const std::size_t skipped = segments.size() - count;
  head.segment_count = static_cast<std::int64_t>(count);
  copy.head.Store(head);
  for (std::size_t i = 0; i < count; ++i) {
    copy.begins_ns[i].store(segments[skipped + i].begin_ns, std::memory_order_release);
    copy.segments[i].Store(segments[skipped + i]);
  }
  count_.store(next, std::memory_order_release);
}

PublishedTimeline::Found PublishedTimeline::Find(std::int64_t stamp_ns) const {
  while (true) {
    const std::uint64_t count = count_.load(std::memory_order_acquire);
    const Found found = FindIn((*copies_)[count % kCopies], stamp_ns);
    // The writer begins to change this copy after it has published kCopies - 1 others.
    if (count_.load(std::memory_order_acquire) - count < kCopies - 1) return found;
  }
}

PublishedTimeline::Found PublishedTimeline::FindIn(const Copy& copy, std::int64_t stamp_ns) {
  Found found{.head = copy.head.Load(), .segment = std::nullopt};
  // A copy that is being changed may hold any count that was ever stored, all within bounds.
  const auto count = static_cast<std::size_t>(found.head.segment_count);
  if (count == 0) return found;
  found.begin_ns = copy.begins_ns[0].load(std::memory_order_acquire);
  const auto begins_after = [](std::int64_t stamp, const std::atomic<std::int64_t>& begin_ns) {
    return stamp < begin_ns.load(std::memory_order_acquire);
  };
  const auto begin = copy.begins_ns.begin();
  const auto after =
      std::upper_bound(begin, begin + static_cast<std::ptrdiff_t>(count), stamp_ns, begins_after);
  if (after == begin) return found;
  found.segment = copy.segments[static_cast<std::size_t>(after - begin) - 1].Load();
  return found;
}

}  // namespace dcloc::client
