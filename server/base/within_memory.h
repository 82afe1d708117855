#pragma once

#include <new>
#include <type_traits>
#include <utility>

#include "absl/status/status.h"

namespace dcloc::server {

/// How a call ends that gets no memory: ResourceExhausted. Made when the program starts: a copy of
/// it, and gRPC's status of it, take no memory.
const absl::Status& OutOfMemory();

/// What `work` returns, or `OutOfMemory` when it gets no memory; OK for one that returns nothing.
/// What it has begun by then must be fit to be let go of.
template <typename Work>
absl::Status WithinMemory(Work&& work) {
  try {
    if constexpr (std::is_void_v<std::invoke_result_t<Work>>) {
      std::forward<Work>(work)();
      return absl::OkStatus();
    } else {
      return std::forward<Work>(work)();
    }
  } catch (const std::bad_alloc&) {
    return OutOfMemory();
  }
}

}  // namespace dcloc::server
