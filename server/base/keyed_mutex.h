#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

namespace dcloc::server {

/// A mutex for each key, there as long as someone has it or waits for it. Thread-safe.
class KeyedMutex {
 public:
  /// Has a key's mutex while it exists; at most as long as the `KeyedMutex`.
  class Lock {
   public:
    explicit Lock(std::shared_ptr<std::mutex> mutex) : mutex_(std::move(mutex)), lock_(*mutex_) {}

   private:
    std::shared_ptr<std::mutex> mutex_;
    std::unique_lock<std::mutex> lock_;  ///< last: it goes first
  };

  /// Waits until nobody else has it.
  Lock Take(const std::string& key) {
    std::shared_ptr<std::mutex> mutex;
    {
      const std::lock_guard lock(mutex_);
      std::erase_if(mutexes_, [](const auto& entry) { return entry.second.expired(); });
      std::weak_ptr<std::mutex>& entry = mutexes_[key];
      mutex = entry.lock();
      if (mutex == nullptr) entry = mutex = std::make_shared<std::mutex>();
    }
    return Lock(std::move(mutex));
  }

 private:
  std::mutex mutex_;
  std::map<std::string, std::weak_ptr<std::mutex>> mutexes_;
};

}  // namespace dcloc::server
