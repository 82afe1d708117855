#pragma once

#include <atomic>
#include <cstddef>

namespace dcloc::server {

/// Address space that is kept for when the process gets no more: a rainy-day fund. gRPC 1.51 ends
/// the process when it gets no memory, and stops to answer when it gets no thread. Nothing is
/// written to it, so it takes no memory before it is given. Thread-safe.
class MemoryReserve {
 public:
  constexpr MemoryReserve() = default;
  MemoryReserve(const MemoryReserve&) = delete;
  MemoryReserve& operator=(const MemoryReserve&) = delete;
  ~MemoryReserve() { Give(); }

  /// The one that the allocator and the start of threads draw on (`app/memory_hooks.cpp`). It is
  /// empty until something is kept in it.
  static MemoryReserve& OfProcess();

  /// Takes `size_bytes`, and from now on again after they were given. Call it once. False, and
  /// nothing is kept, if there is not so much.
  bool Keep(std::size_t size_bytes);

  /// Gives it to whoever asks the system next; when this returns, it can be had. Allocates nothing.
  void Give() noexcept;

  /// To be called from time to time. Gives it where hardly anything is left besides, before
  /// somebody goes without who does not draw on it; takes it again where a quarter of it would be
  /// left besides. False if it is given.
  bool Tend();

  /// Whether memory is short: all that was kept is given.
  bool IsGiven() const { return size_bytes_ > 0 && pages_ == nullptr; }

 private:
  std::atomic<std::size_t> size_bytes_ = 0;
  std::atomic<void*> pages_ = nullptr;
  std::atomic_flag giving_;
};

}  // namespace dcloc::server
