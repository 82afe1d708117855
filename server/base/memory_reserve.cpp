#include "server/base/memory_reserve.h"

#include <sys/mman.h>

namespace dcloc::server {
namespace {

constinit MemoryReserve process_reserve;

/// Writable pages: those count against a limit of the address space, and to a system that does not
/// promise more than it has. Null if there are none.
void* Map(std::size_t size_bytes) noexcept {
  void* const pages =
      mmap(nullptr, size_bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  return pages == MAP_FAILED ? nullptr : pages;
}

}  // namespace

MemoryReserve& MemoryReserve::OfProcess() { return process_reserve; }

bool MemoryReserve::Keep(std::size_t size_bytes) {
  pages_ = Map(size_bytes);
  if (pages_ == nullptr) return false;
  size_bytes_ = size_bytes;
  return true;
}

// Who comes second waits until the first one has given it: a mutex of the libraries may allocate.
void MemoryReserve::Give() noexcept {
  while (giving_.test_and_set(std::memory_order_acquire)) {
  }
  if (void* const pages = pages_.exchange(nullptr)) munmap(pages, size_bytes_);
  giving_.clear(std::memory_order_release);
}

bool MemoryReserve::Tend() {
  if (size_bytes_ == 0) return true;
  const bool was_given = IsGiven();
  const std::size_t left_bytes = size_bytes_ / (was_given ? 4 : 16);
  void* const left = Map(left_bytes);
  if (left == nullptr) {
    Give();
    return false;
  }
  if (was_given) pages_ = Map(size_bytes_);
  munmap(left, left_bytes);
  return !IsGiven();
}

}  // namespace dcloc::server
