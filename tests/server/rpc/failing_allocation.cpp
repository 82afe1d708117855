#include "tests/server/rpc/failing_allocation.h"

#include <execinfo.h>
#include <pthread.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <new>

#include "absl/debugging/symbolize.h"
#include "absl/strings/match.h"
#include "absl/strings/string_view.h"

namespace dcloc::server {
namespace {

constexpr int kNone = -1;

std::atomic<int> allocations_left = kNone;
std::atomic<bool> has_failed = false;
std::atomic<pthread_t> spared_thread;

enum class Owner { kServer, kGrpc, kHelper };

Owner OwnerByName(const void* code) {
  std::array<char, 256> name{};
  if (!absl::Symbolize(code, name.data(), static_cast<int>(name.size()))) return Owner::kGrpc;
  const absl::string_view text(name.data());
  constexpr std::array kHelpers = {"std::", "__gnu_cxx::", "absl::", "google::", "operator new"};
  for (const char* helper : kHelpers) {
    if (absl::StartsWith(text, helper)) return Owner::kHelper;
  }
  return absl::StartsWith(text, "dcloc::") ? Owner::kServer : Owner::kGrpc;
}

/// Names are found slowly, so owners are remembered: each with its code's address, in one word.
Owner OwnerOf(const void* code) {
  static std::array<std::atomic<std::uintptr_t>, 8191> remembered;
  const auto address = reinterpret_cast<std::uintptr_t>(code);
  std::atomic<std::uintptr_t>& place = remembered[address % remembered.size()];
  const std::uintptr_t there = place;
  if (there >> 2 == address) return static_cast<Owner>(there & 3);
  const Owner owner = OwnerByName(code);
  place = address << 2 | static_cast<std::uintptr_t>(owner);
  return owner;
}

/// Of the calls that end at `caller`, which asked for memory, the newest of who is no helper.
bool IsServers(const void* caller) {
  std::array<void*, 40> frames;
  const auto end = frames.begin() + backtrace(frames.data(), static_cast<int>(frames.size()));
  for (auto frame = std::find(frames.begin(), end, caller); frame != end; ++frame) {
    // Where a call returns to may be the function behind it already.
    const Owner owner = OwnerOf(static_cast<const char*>(*frame) - 1);
    if (owner != Owner::kHelper) return owner == Owner::kServer;
  }
  return false;
}

bool MustFail(const void* caller) {
  if (allocations_left == kNone || pthread_self() == spared_thread || !IsServers(caller)) {
    return false;
  }
  int left = allocations_left;
  while (left != kNone && !allocations_left.compare_exchange_weak(left, left - 1)) {
  }
  if (left != 0) return false;
  has_failed = true;
  return true;
}

}  // namespace

FailingAllocation::FailingAllocation(int skipped_count) {
  std::array<void*, 1> frames;
  backtrace(frames.data(), 1);  // the first one loads a library
  absl::InitializeSymbolizer(program_invocation_name);
  has_failed = false;
  spared_thread = pthread_self();
  allocations_left = skipped_count;
}

FailingAllocation::~FailingAllocation() { allocations_left = kNone; }

bool FailingAllocation::HasFailed() { return has_failed; }

}  // namespace dcloc::server

// Replaces that of the standard library, in the whole program.
void* operator new(std::size_t size) {
  if (dcloc::server::MustFail(__builtin_return_address(0))) throw std::bad_alloc();
  void* const block = std::malloc(std::max<std::size_t>(size, 1));
  if (block == nullptr) throw std::bad_alloc();
  return block;
}

void operator delete(void* block) noexcept { std::free(block); }
void operator delete(void* block, std::size_t /*size*/) noexcept { std::free(block); }
