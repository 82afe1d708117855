#pragma once

#include <grpcpp/server_context.h>

#include <functional>
#include <memory>
#include <type_traits>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/base/status.h"
#include "server/base/within_memory.h"
#include "server/rpc/rpc_context.h"

namespace dcloc::server {

/// The end of a unary call: whoever holds it finishes the call, once. Who lets go of it without
/// that has got no memory, which then is the call's end.
template <typename Request>
class UnaryCompletion {
 public:
  UnaryCompletion(const RpcContext& host, grpc::CallbackServerContext* context,
                  grpc::ServerUnaryReactor* reactor, const Request* request)
      : host_(host),
        context_(context),
        reactor_(reactor),
        request_(request),
        token_(host.open_calls) {}
  UnaryCompletion(UnaryCompletion&& other) noexcept
      : host_(other.host_),
        context_(other.context_),
        reactor_(std::exchange(other.reactor_, nullptr)),
        request_(other.request_),
        principal_(std::move(other.principal_)),
        token_(std::move(other.token_)) {}
  UnaryCompletion& operator=(UnaryCompletion&&) = delete;
  ~UnaryCompletion() { Finish(OutOfMemory()); }

  /// Whether the caller may make the call; if not, it is finished.
  bool Authorize() {
    absl::StatusOr<Principal> principal = host_.access.Authorize(*context_, Request::descriptor());
    if (!principal.ok()) {
      Finish(principal.status());
      return false;
    }
    principal_ = *std::move(principal);
    return true;
  }

  const Principal& principal() const { return principal_; }

  /// Notes the call where it changes something. Context, request and response are gone afterwards.
  void operator()(const absl::Status& status) {
    WithinMemory([&] {
      host_.operations.Note(*context_, principal_, *request_, status);
    }).IgnoreError();
    Finish(status);
  }

 private:
  void Finish(const absl::Status& status) {
    if (reactor_ != nullptr) std::exchange(reactor_, nullptr)->Finish(ToGrpc(status));
  }

  const RpcContext& host_;
  grpc::CallbackServerContext* context_;
  grpc::ServerUnaryReactor* reactor_;  ///< null once the call is finished
  const Request* request_;
  Principal principal_;
  OpenCalls::Token token_;
};

/// Answers a unary call, if the caller has the permission. `work` begins on a thread of the host's
/// pool, and gets the call's `UnaryCompletion`, which it may hand on. Calls that read whole maps
/// use the lengthy `lane`.
template <typename Request, typename Work>
grpc::ServerUnaryReactor* StartUnary(const RpcContext& host, grpc::CallbackServerContext* context,
                                     const Request* request, Work work, Lane lane = Lane::kQuick) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  // What is thrown behind gRPC's back would end the process.
  WithinMemory([&] {
    host.pool.Post(
        [work = std::move(work),
         end = UnaryCompletion<Request>(host, context, reactor, request)]() mutable {
          if (end.Authorize()) work(std::move(end));
        },
        lane);
  }).IgnoreError();  // letting go of the task has finished the call
  return reactor;
}

/// The same for work that ends where it began: it fills the response and returns the call's
/// absl::Status. Its argument is the calling Principal, or nothing.
template <typename Request, typename Work>
grpc::ServerUnaryReactor* RunUnary(const RpcContext& host, grpc::CallbackServerContext* context,
                                   const Request* request, Work work, Lane lane = Lane::kQuick) {
  return StartUnary(
      host, context, request,
      [work = std::move(work)](UnaryCompletion<Request> end) {
        if constexpr (std::is_invocable_v<Work, const Principal&>) {
          end(work(end.principal()));
        } else {
          end(work());
        }
      },
      lane);
}

/// How a call ends whose answer comes later; to be called once.
using UnaryDone = std::function<void(const absl::Status& status)>;

/// The same for a call that waits for others: `work(principal, done)` must not wait, and the
/// request and the response live until `done`.
template <typename Request, typename Work>
grpc::ServerUnaryReactor* RunUnaryAsync(const RpcContext& host,
                                        grpc::CallbackServerContext* context,
                                        const Request* request, Work work) {
  return StartUnary(host, context, request, [work = std::move(work)](UnaryCompletion<Request> end) {
    const Principal principal = end.principal();
    auto shared = std::make_shared<UnaryCompletion<Request>>(std::move(end));
    work(principal, [shared](const absl::Status& status) { (*shared)(status); });
  });
}

}  // namespace dcloc::server
