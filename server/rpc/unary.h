#pragma once

#include <grpcpp/server_context.h>

#include <functional>
#include <memory>
#include <type_traits>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/base/status.h"
#include "server/rpc/storage_host.h"

namespace dcloc::server {

/// Answers a unary call on a thread of the host's pool, if the caller has the permission. `work`
/// fills the response and returns the call's absl::Status; its argument is the calling Principal,
/// or nothing. Calls that read whole maps use the lengthy `lane`.
template <typename Request, typename Work>
grpc::ServerUnaryReactor* AnswerOn(const StorageHost& host, grpc::CallbackServerContext* context,
                                   const Request* /*request*/, Work work,
                                   Lane lane = Lane::kQuick) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  host.pool.Post(
      [&host, context, reactor, work = std::move(work), token = OpenCalls::Token(host.open_calls)] {
        const absl::StatusOr<Principal> principal =
            host.access.Authorize(*context, Request::descriptor());
        if (!principal.ok()) {
          reactor->Finish(ToGrpc(principal.status()));
        } else if constexpr (std::is_invocable_v<Work, const Principal&>) {
          reactor->Finish(ToGrpc(work(*principal)));
        } else {
          reactor->Finish(ToGrpc(work()));
        }
      },
      lane);
  return reactor;
}

/// How a call ends whose answer comes later; to be called once.
using UnaryDone = std::function<void(const absl::Status& status)>;

/// The same for a call that waits for others: `work(principal, done)` must not wait, and the
/// request and the response live until `done`.
template <typename Request, typename Work>
grpc::ServerUnaryReactor* AnswerLaterOn(const StorageHost& host,
                                        grpc::CallbackServerContext* context,
                                        const Request* /*request*/, Work work) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  auto token = std::make_shared<const OpenCalls::Token>(host.open_calls);
  host.pool.Post([&host, context, reactor, work = std::move(work), token = std::move(token)] {
    const absl::StatusOr<Principal> principal =
        host.access.Authorize(*context, Request::descriptor());
    if (!principal.ok()) return reactor->Finish(ToGrpc(principal.status()));
    work(*principal,
         [reactor, token](const absl::Status& status) { reactor->Finish(ToGrpc(status)); });
  });
  return reactor;
}

}  // namespace dcloc::server
