#pragma once

#include <grpcpp/server_context.h>

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

}  // namespace dcloc::server
