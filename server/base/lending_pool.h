#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace dcloc::server {

/// Lends objects that are costly to make and worth nothing between two uses. What came back last is
/// lent first, so that there are as many as were ever lent at once and the memory of the next one
/// is still in the caches. Thread-safe; the lock is held to push or pop a pointer.
template <typename T>
class LendingPool {
 public:
  /// Gives its object back at its end. The pool outlives it.
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

  /// Makes an object where all are lent.
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

  /// Objects that nobody uses.
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
