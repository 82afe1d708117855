// What gRPC and the other libraries ask the system for: memory and threads. Where the system has
// none, the process' reserve is given, and the system is asked again. glibc lets a program replace
// both; see decision 0205.

#include <dlfcn.h>
#include <pthread.h>

#include <cerrno>
#include <cstddef>

#include "server/base/memory_reserve.h"

namespace {

/// Who asks for more is refused, and ends alone (`WithinMemory`): it must not use up what gRPC,
/// whose blocks are smaller, cannot do without.
constexpr std::size_t kMaxDrawn_bytes = std::size_t{1} << 18;

template <typename Allocate>
void* AllocateOrDraw(std::size_t size_bytes, Allocate allocate) {
  void* const block = allocate();
  if (block != nullptr || size_bytes == 0) return block;
  dcloc::server::MemoryReserve::OfProcess().Give();
  return size_bytes > kMaxDrawn_bytes ? nullptr : allocate();
}

}  // namespace

extern "C" {

// glibc's own, under the names that it keeps for who replaces the others.
// NOLINTBEGIN(bugprone-reserved-identifier)
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* block, std::size_t size);
void* __libc_memalign(std::size_t align, std::size_t size);
// NOLINTEND(bugprone-reserved-identifier)

void* malloc(std::size_t size) noexcept {
  return AllocateOrDraw(size, [=] { return __libc_malloc(size); });
}

void* calloc(std::size_t count, std::size_t size) noexcept {
  std::size_t size_bytes = 0;
  if (__builtin_mul_overflow(count, size, &size_bytes)) size_bytes = 0;  // glibc refuses it
  return AllocateOrDraw(size_bytes, [=] { return __libc_calloc(count, size); });
}

void* realloc(void* block, std::size_t size) noexcept {
  return AllocateOrDraw(size, [=] { return __libc_realloc(block, size); });
}

void* memalign(std::size_t align, std::size_t size) noexcept {
  return AllocateOrDraw(size, [=] { return __libc_memalign(align, size); });
}

void* aligned_alloc(std::size_t align, std::size_t size) noexcept { return memalign(align, size); }

int posix_memalign(void** block, std::size_t align, std::size_t size) noexcept {
  if (align % sizeof(void*) != 0 || align == 0 || (align & (align - 1)) != 0) return EINVAL;
  void* const made = memalign(align, size);
  if (made == nullptr && size > 0) return ENOMEM;
  *block = made;
  return 0;
}

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*run)(void*),
                   void* argument) noexcept {
  static const auto create =
      reinterpret_cast<decltype(&pthread_create)>(dlsym(RTLD_NEXT, "pthread_create"));
  const int error = create(thread, attributes, run, argument);
  if (error != EAGAIN) return error;
  dcloc::server::MemoryReserve::OfProcess().Give();
  return create(thread, attributes, run, argument);
}

}  // extern "C"
