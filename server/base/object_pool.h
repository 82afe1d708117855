#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "server/base/within_memory.h"

namespace dcloc::server {

/// Lends objects that are costly to make and hold no state between two uses. The object that was
/// returned last is lent first. So there are only as many as were ever lent at once, and the next
/// one's memory is still in the caches. Thread-safe; the lock is held to push or pop a pointer.
template <typename T>
class ObjectPool {
 public:
  /// A lent object; returned to the pool when this is destroyed. The pool outlives it.
  class Lease {
   public:
    Lease(ObjectPool& pool, std::unique_ptr<T> object) : pool_(&pool), object_(std::move(object)) {}
    Lease(Lease&&) noexcept = default;
    Lease& operator=(Lease&&) = delete;
    ~Lease() {
      if (object_ != nullptr) pool_->TakeBack(std::move(object_));
    }

    T& operator*() const { return *object_; }

   private:
    ObjectPool* pool_;
    std::unique_ptr<T> object_;
  };

  ObjectPool() = default;
  ObjectPool(const ObjectPool&) = delete;
  ObjectPool& operator=(const ObjectPool&) = delete;

  /// Creates an object if all are lent.
  Lease Acquire() {
    {
      const std::lock_guard lock(mutex_);
      if (!idle_.empty()) {
        Lease lease(*this, std::move(idle_.back()));
        idle_.pop_back();
        return lease;
      }
    }
    return Lease(*this, std::make_unique<T>());
  }

  /// The objects that are not lent.
  std::size_t idle_count() const {
    const std::lock_guard lock(mutex_);
    return idle_.size();
  }

 private:
  /// Without memory to remember it, it is gone.
  void TakeBack(std::unique_ptr<T> object) {
    const std::lock_guard lock(mutex_);
    WithinMemory([&] { idle_.push_back(std::move(object)); }).IgnoreError();
  }

  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<T>> idle_;
};

}  // namespace dcloc::server
