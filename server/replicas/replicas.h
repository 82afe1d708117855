#pragma once

#include <grpcpp/client_context.h>
#include <grpcpp/server_context.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "dcloc/v1/admin_service.grpc.pb.h"
#include "server/base/status.h"
#include "server/base/within_memory.h"
#include "server/base/worker_pool.h"
#include "server/identity/access_control.h"
#include "server/replicas/replica_bounds.h"
#include "server/replicas/replica_channels.h"
#include "server/replicas/replica_directory.h"

namespace dcloc::server {

/// What one replica said to a call that was handed on.
template <typename Response>
struct ReplicaAnswer {
  std::string address;
  grpc::Status status;
  Response response;
};

/// The other servers of the fleet: calls are handed on to them in the caller's name, with the
/// caller's own token and within a bounded time. A call that was handed on is not handed on again.
/// Thread-safe.
class Replicas {
 public:
  using Stub = v1::AdminService::Stub;
  template <typename Request, typename Response>
  using Method = void (v1::AdminService::StubInterface::async_interface::*)(
      grpc::ClientContext*, const Request*, Response*, std::function<void(grpc::Status)>);

  /// What hands calls on; all outlive it. `directory` is null for a server by itself.
  struct Parts {
    ReplicaDirectory* directory;
    const AccessControl& access;
    WorkerPool& pool;
  };

  Replicas(const Parts& parts, ReplicaTls tls, const ReplicaBounds& bounds)
      : parts_(parts), channels_(std::move(tls)), bounds_(bounds) {}

  const ReplicaBounds& bounds() const { return bounds_; }

  /// From now on the others know this server by `address`. Before the first call.
  void Join(std::string address);

  /// This server's address among the others; empty for a server by itself.
  const std::string& own_address() const { return own_address_; }

  /// Servers that share the catalogue, as this one knows them, itself among them; 1 by itself.
  int known_count() const;

  /// Whom to ask beside this server for a call: nobody if it was handed on already.
  std::vector<std::string> OthersFor(const grpc::CallbackServerContext& context) const;

  /// Whether calls can be made in the caller's name: a certificate cannot be handed on.
  bool CanHandOn(const grpc::CallbackServerContext& context) const;

  /// The one that a request names; none when it is this server. NotFound names those that there
  /// are; FailedPrecondition when the call was handed on to another one.
  absl::StatusOr<std::vector<std::string>> Named(const grpc::CallbackServerContext& context,
                                                 const std::string& address) const;

  /// Asks each of `addresses` at once, and calls `done` on the pool with what they said within
  /// `bound`, one of `bounds`, in their order. The call of `context` must not end before.
  template <typename Request, typename Response>
  void Ask(const std::vector<std::string>& addresses, const grpc::CallbackServerContext& context,
           const Request& request, Method<Request, Response> method,
           std::chrono::milliseconds bound,
           std::function<void(std::vector<ReplicaAnswer<Response>>)> done);

  /// A stub of a replica and a context in the caller's name, without a time limit of its own: who
  /// calls sets one of `bounds`.
  /// FailedPrecondition when the caller proves itself by a certificate, which cannot be handed on.
  struct Line {
    std::unique_ptr<Stub> stub;
    std::shared_ptr<grpc::ClientContext> context;
  };
  absl::StatusOr<Line> Call(const std::string& address, const grpc::CallbackServerContext& context);

 private:
  template <typename Request, typename Response>
  struct Question;

  const Parts parts_;
  ReplicaChannels channels_;
  const ReplicaBounds bounds_;
  std::string own_address_;
};

template <typename Request, typename Response>
struct Replicas::Question {
  Request request;
  std::vector<Line> lines;
  std::vector<ReplicaAnswer<Response>> answers;
  std::atomic<std::size_t> open_count;
  std::function<void(std::vector<ReplicaAnswer<Response>>)> done;
};

template <typename Request, typename Response>
void Replicas::Ask(const std::vector<std::string>& addresses,
                   const grpc::CallbackServerContext& context, const Request& request,
                   Method<Request, Response> method, std::chrono::milliseconds bound,
                   std::function<void(std::vector<ReplicaAnswer<Response>>)> done) {
  auto question = std::make_shared<Question<Request, Response>>();
  question->request = request;
  question->lines.resize(addresses.size());
  question->answers.resize(addresses.size());
  question->open_count = addresses.size() + 1;
  question->done = std::move(done);
  const auto end = [question, &pool = parts_.pool] {
    if (--question->open_count > 0) return;
    // The contexts go with it, not in a call that one of them is still in. Without memory whoever
    // waits is let go of with it.
    WithinMemory([&] {
      pool.Post([question] { question->done(std::move(question->answers)); });
    }).IgnoreError();
  };
  const auto deadline = std::min(context.deadline(), std::chrono::system_clock::now() + bound);
  for (std::size_t i = 0; i < addresses.size(); ++i) {
    ReplicaAnswer<Response>& answer = question->answers[i];
    answer.address = addresses[i];
    absl::StatusOr<Line> line = Call(addresses[i], context);
    if (!line.ok()) {
      answer.status = ToGrpc(line.status());
      end();
      continue;
    }
    question->lines[i] = *std::move(line);
    question->lines[i].context->set_deadline(deadline);
    (question->lines[i].stub->async()->*method)(question->lines[i].context.get(),
                                                &question->request, &answer.response,
                                                [question, end, i](const grpc::Status& status) {
                                                  question->answers[i].status = status;
                                                  end();
                                                });
  }
  end();
}

}  // namespace dcloc::server
