#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace dcloc::server {

/// What a shutdown must end because it may wait for long, such as another server's stream or a
/// vehicle that has not come yet. A shutdown runs all hooks, and those that are added later at
/// once. Thread-safe.
class ShutdownHooks {
 public:
  /// `hook` is called once, at the shutdown, if `owner` still lives; at once where that has been.
  template <typename Owner>
  void Add(const std::shared_ptr<Owner>& owner, std::function<void(Owner&)> hook) {
    Entry entry{.owner = owner,
                .run = [held = std::weak_ptr<Owner>(owner), hook = std::move(hook)] {
                  if (const std::shared_ptr<Owner> living = held.lock()) hook(*living);
                }};
    {
      const std::lock_guard lock(mutex_);
      std::erase_if(entries_, [](const Entry& old) { return old.owner.expired(); });
      if (!has_run_) return entries_.push_back(std::move(entry));
    }
    entry.run();
  }

  /// Runs all. Without the lock, as a hook may release the last reference to its owner.
  void RunAll() {
    std::vector<Entry> entries;
    {
      const std::lock_guard lock(mutex_);
      has_run_ = true;
      entries.swap(entries_);
    }
    for (const Entry& entry : entries) entry.run();
  }

 private:
  struct Entry {
    std::weak_ptr<void> owner;
    std::function<void()> run;
  };

  std::mutex mutex_;
  bool has_run_ = false;
  std::vector<Entry> entries_;
};

}  // namespace dcloc::server
