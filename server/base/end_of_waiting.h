#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace dcloc::server {

/// What waits for something that may come long after a stop began, such as another server's stream
/// or a vehicle that has not come yet. A stop ends all of it, and whatever begins to wait later.
/// Thread-safe.
class EndOfWaiting {
 public:
  /// `end` is called once, at the stop, if `waiting` still lives; at once where that has been.
  template <typename Waiting>
  void Add(const std::shared_ptr<Waiting>& waiting, std::function<void(Waiting&)> end) {
    Entry entry{.waiting = waiting,
                .end = [held = std::weak_ptr<Waiting>(waiting), end = std::move(end)] {
                  if (const std::shared_ptr<Waiting> living = held.lock()) end(*living);
                }};
    {
      const std::lock_guard lock(mutex_);
      std::erase_if(entries_, [](const Entry& old) { return old.waiting.expired(); });
      if (!has_ended_) return entries_.push_back(std::move(entry));
    }
    entry.end();
  }

  /// Ends all. Without the lock, as what ends may be the last to hold itself.
  void EndAll() {
    std::vector<Entry> entries;
    {
      const std::lock_guard lock(mutex_);
      has_ended_ = true;
      entries.swap(entries_);
    }
    for (const Entry& entry : entries) entry.end();
  }

 private:
  struct Entry {
    std::weak_ptr<void> waiting;
    std::function<void()> end;
  };

  std::mutex mutex_;
  bool has_ended_ = false;
  std::vector<Entry> entries_;
};

}  // namespace dcloc::server
