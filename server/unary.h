#pragma once

#include <grpcpp/server_context.h>

#include <utility>

#include "absl/status/status.h"
#include "server/status.h"
#include "server/storage_host.h"

namespace dcloc::server {

/// Answers a unary call from the host's pool: `work` fills the response and gives the call's
/// absl::Status.
template <typename Work>
grpc::ServerUnaryReactor* AnswerOn(const StorageHost& host, grpc::CallbackServerContext* context,
                                   Work work) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  host.pool.Post([reactor, work = std::move(work), token = OpenCalls::Token(host.open_calls)] {
    reactor->Finish(ToGrpc(work()));
  });
  return reactor;
}

}  // namespace dcloc::server
