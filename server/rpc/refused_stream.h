#pragma once

#include <new>
#include <utility>

#include "server/base/status.h"
#include "server/base/within_memory.h"

namespace dcloc::server {

/// A call that ends at once, as it got no memory to begin.
template <typename Reactor>
class RefusedStream final : public Reactor {
 public:
  RefusedStream() { this->Finish(ToGrpc(OutOfMemory())); }
  void OnDone() override { delete this; }
};

/// What `begin` gives, which is a new call's reactor. Without memory for one, gRPC would say that
/// there is no such call.
template <typename Reactor, typename Begin>
Reactor* BeginWithinMemory(Begin&& begin) {
  try {
    return std::forward<Begin>(begin)();
  } catch (const std::bad_alloc&) {
    return new RefusedStream<Reactor>();
  }
}

}  // namespace dcloc::server
