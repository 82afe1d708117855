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

/// The same for `work` that fills `message`. A message of protobuf that got no memory in between is
/// fit for nothing, not even to be destroyed: then it is made anew, and what it held is lost.
template <typename Message, typename Work>
absl::Status FillWithinMemory(Message* message, Work&& work) {
  absl::Status status = WithinMemory(std::forward<Work>(work));
  if (status == OutOfMemory()) new (message) Message();
  return status;
}

}  // namespace dcloc::server
