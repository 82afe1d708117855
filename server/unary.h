#pragma once

#include <grpcpp/server_context.h>

#include <utility>

#include "absl/status/status.h"
#include "server/status.h"
#include "server/worker_pool.h"

namespace dcloc::server {

/// Answers a unary call from `pool`: `work` fills the response and gives the call's absl::Status.
template <typename Work>
grpc::ServerUnaryReactor* AnswerOn(WorkerPool& pool, grpc::CallbackServerContext* context,
                                   Work work) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  pool.Post([reactor, work = std::move(work)] { reactor->Finish(ToGrpc(work())); });
  return reactor;
}

}  // namespace dcloc::server
