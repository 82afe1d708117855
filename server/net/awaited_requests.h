#pragma once

#include <grpc/grpc.h>
#include <grpcpp/impl/rpc_service_method.h>

#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <utility>

#include "server/base/peer_wait.h"
#include "server/base/waiting_calls.h"

namespace dcloc::server {

/// The calls whose only request has not come: they are bounded in number and in time.
///
/// gRPC tells a server of such a call once its request is there, and keeps one that sends none for
/// as long as its peer likes. A handler made by `Awaiting` is told of the call when its headers
/// come, reads the request itself, and only then hands the call on. Thread-safe.
class AwaitedRequests {
 public:
  using Clock = PeerWait::Clock;

  struct Bounds {
    WaitingBounds count;
    std::chrono::milliseconds time{0};  ///< of a call
  };

  /// `bounds` is asked for each call. `faults` outlives this and counts those that were ended.
  AwaitedRequests(std::function<Bounds()> bounds, PeerFaultCounts& faults)
      : bounds_(std::move(bounds)), faults_(faults) {}

  /// A handler for a method that gRPC takes for one that streams requests; `handler` is one that
  /// takes a single request. This outlives it.
  std::unique_ptr<grpc::internal::MethodHandler> Awaiting(
      std::unique_ptr<grpc::internal::MethodHandler> handler);

  int count() const;

  /// Ends the calls whose request did not come in time.
  void EndOverdue(Clock::time_point now);

 private:
  class Handler;
  class Call;

  void Begin(Call& call);
  void Forget(Call& call);

  const std::function<Bounds()> bounds_;
  PeerFaultCounts& faults_;
  mutable std::mutex mutex_;
  std::set<Call*> calls_;
  WaitingCalls<Call> waiting_;
};

}  // namespace dcloc::server
