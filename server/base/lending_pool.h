#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace dcloc::server {

/// Lends objects that are costly to make and hold no state between two uses. The object that was
/// returned last is lent first. So there are only as many as were ever lent at once, and the next
/// one's memory is still in the caches. Thread-safe; the lock is held to push or pop a pointer.
template <typename T>
class LendingPool {
 public:
  /// A lent object; returned to the pool when this is destroyed. The pool outlives it.
  class Loan {
   public:
    Loan(LendingPool& pool, std::unique_ptr<T> object) : pool_(&pool), object_(std::move(object)) {}
    Loan(Loan&&) noexcept = default;
    Loan& operator=(Loan&&) = delete;
    ~Loan() {
      if (object_ != nullptr) pool_->TakeBack(std::move(object_));
    }

    T& operator*() const { return *object_; }

   private:
    LendingPool* pool_;
    std::unique_ptr<T> object_;
  };

  LendingPool() = default;
  LendingPool(const LendingPool&) = delete;
  LendingPool& operator=(const LendingPool&) = delete;

  /// Creates an object if all are lent.
  Loan Lend() {
    {
      const std::lock_guard lock(mutex_);
      if (!idle_.empty()) {
        Loan loan(*this, std::move(idle_.back()));
        idle_.pop_back();
        return loan;
      }
    }
    return Loan(*this, std::make_unique<T>());
  }

  /// The objects that are not lent.
  std::size_t idle_count() const {
    const std::lock_guard lock(mutex_);
    return idle_.size();
  }

 private:
  void TakeBack(std::unique_ptr<T> object) {
    const std::lock_guard lock(mutex_);
    idle_.push_back(std::move(object));
  }

  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<T>> idle_;
};

}  // namespace dcloc::server
