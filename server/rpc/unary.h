#pragma once

#include <grpcpp/server_context.h>

#include <type_traits>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/base/status.h"
#include "server/rpc/storage_host.h"

namespace dcloc::server {

/// Answers a unary call from the host's pool, if the caller may make it: `work` fills the response
/// and gives the call's absl::Status. It takes nothing, or the Principal who calls. `lane` is the
/// lengthy one for what reads whole maps.
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
