#pragma once

#include <grpcpp/server_context.h>

#include <functional>
#include <memory>
#include <type_traits>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/base/status.h"
#include "server/rpc/rpc_context.h"

namespace dcloc::server {

/// The end of a unary call that the caller may make: whoever holds it finishes the call, once.
template <typename Request>
class UnaryCompletion {
 public:
  UnaryCompletion(const RpcContext& host, grpc::CallbackServerContext* context,
                  grpc::ServerUnaryReactor* reactor, const Request* request, Principal principal,
                  OpenCalls::Token token)
      : host_(host),
        context_(context),
        reactor_(reactor),
        request_(request),
        principal_(std::move(principal)),
        token_(std::move(token)) {}

  const Principal& principal() const { return principal_; }

  /// Notes the call where it changes something. Context, request and response are gone afterwards.
  void operator()(const absl::Status& status) {
    host_.operations.Note(*context_, principal_, *request_, status);
    reactor_->Finish(ToGrpc(status));
  }

 private:
  const RpcContext& host_;
  grpc::CallbackServerContext* context_;
  grpc::ServerUnaryReactor* reactor_;
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
  host.pool.Post(
      [&host, context, reactor, request, work = std::move(work),
       token = OpenCalls::Token(host.open_calls)]() mutable {
        absl::StatusOr<Principal> principal =
            host.access.Authorize(*context, Request::descriptor());
        if (!principal.ok()) return reactor->Finish(ToGrpc(principal.status()));
        work(UnaryCompletion<Request>(host, context, reactor, request, *std::move(principal),
                                      std::move(token)));
      },
      lane);
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
