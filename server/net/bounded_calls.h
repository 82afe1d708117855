#pragma once

#include <grpcpp/server_context.h>
#include <grpcpp/support/server_interceptor.h>

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include "server/base/peer_wait.h"

namespace dcloc::server {

/// Bounds how long peers hold calls that no stream of ours looks after. Thread-safe.
///
/// Calls of gRPC's reflection, which everybody may make, end some time after their begin: each
/// holds a thread of gRPC's, which waits for the next question. How many those are, the server's
/// resource quota says. Other calls end some time after they were answered, if the answer is not
/// read: until then it stays in memory. `Localize` looks after itself, and is left out.
class BoundedCalls {
 public:
  using Clock = PeerWait::Clock;

  struct Times {
    std::chrono::milliseconds reflection;
    std::chrono::milliseconds reading;
  };

  /// `times` is asked for each call. `faults` outlives this and counts those that were ended.
  BoundedCalls(std::function<Times()> times, PeerFaultCounts& faults)
      : times_(std::move(times)), faults_(faults) {}

  /// What tells this of calls. This outlives it.
  std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> Watching();

  /// Ends the calls whose time is over.
  void EndOverdue(Clock::time_point now);

 private:
  class Factory;
  class Call;

  const std::function<Times()> times_;
  PeerFaultCounts& faults_;
  std::mutex mutex_;
  std::map<Call*, Clock::time_point> deadlines_;
};

}  // namespace dcloc::server
