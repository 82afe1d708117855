#pragma once

#include <grpcpp/server_context.h>
#include <grpcpp/support/server_callback.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_format.h"
#include "server/base/status.h"
#include "server/base/within_memory.h"
#include "server/rpc/rpc_context.h"
#include "server/rpc/wire.h"

namespace dcloc::server {

/// A call whose caller streams requests. First it is checked whether the caller may make it. Then
/// each request is read, taken on the call's strand, and only then the next one is read. A caller
/// who sends nothing for `peer_timeout_ms` is ended.
template <typename Request, typename Response>
class ReadStream : public grpc::ServerReadReactor<grpc::ByteBuffer>,
                   public PeerBoundCall,
                   public std::enable_shared_from_this<ReadStream<Request, Response>> {
 public:
  void OnReadDone(bool ok) override {
    peer_wait_.End();
    PostOrRefuse(
        [self = this->shared_from_this(), ok] { ok ? self->TakeNext() : self->TakeEnd(); });
  }

  void OnDone() override { const std::shared_ptr<ReadStream> last = std::move(self_); }

  void CheckPeer(PeerWait::Clock::time_point now) override {
    if (!peer_wait_.TakeOverdue(now)) return;
    const absl::Status posted = WithinMemory(
        [this] { strand_.Post([self = this->shared_from_this()] { self->GiveUp(); }); });
    if (!posted.ok()) context_->TryCancel();
  }

 protected:
  ReadStream(const RpcContext& host, grpc::CallbackServerContext* context,
             grpc::ByteBuffer* response)
      : host_(host),
        context_(context),
        response_(response),
        token_(host.open_calls),
        strand_(host.pool) {
    strand_.SetLane(Lane::kLengthy);
  }

  /// Begins the call. `stream` lives until the call is done and the pool has let go of it.
  template <typename Stream>
  static Stream* Begin(std::shared_ptr<Stream> stream) {
    ReadStream& base = *stream;
    base.host_.peer_bound_calls.Add(stream);
    base.self_ = stream;
    base.PostOrRefuse([stream] { static_cast<ReadStream&>(*stream).CheckCaller(); });
    return stream.get();
  }

  const RpcContext& host() const { return host_; }

  /// Who calls; known when requests are taken.
  const Principal& principal() const { return principal_; }

  // On the strand.

  /// An error ends the call.
  virtual absl::Status Take(const Request& request) = 0;

  /// All requests have been taken; the call ends.
  virtual absl::Status Complete(Response* response) = 0;

  /// Lets go of what was taken. Called before the client hears of the end.
  virtual void Release() = 0;

 private:
  /// Nothing may be thrown into gRPC's threads, nor a call wait for a task that is not there.
  template <typename Work>
  void PostOrRefuse(Work work) {
    const absl::Status posted = WithinMemory([&] { strand_.Post(std::move(work)); });
    if (!posted.ok()) Refuse(posted);
  }

  void CheckCaller() {
    const absl::Status status = WithinMemory([this]() -> absl::Status {
      absl::StatusOr<Principal> principal =
          host_.access.Authorize(*context_, Request::descriptor());
      if (!principal.ok()) return principal.status();
      principal_ = *std::move(principal);
      return absl::OkStatus();
    });
    status.ok() ? ReadNext() : Refuse(status);
  }

  void ReadNext() {
    peer_wait_.Begin(std::chrono::milliseconds(host_.limits.peer_timeout_ms));
    this->StartRead(&bytes_);
  }

  void TakeNext() {
    if (ended_) return;
    const absl::Status status = WithinMemory([this]() -> absl::Status {
      absl::Status parsed = ParseMessage(&bytes_, &request_);
      if (first_request_.empty()) first_request_ = OperationLog::TextOf(request_);
      return parsed.ok() ? Take(request_) : parsed;
    });
    status.ok() ? ReadNext() : End(status);
  }

  void TakeEnd() {
    if (ended_) return;
    if (context_->IsCancelled()) return End(absl::CancelledError("cancelled"));
    End(WithinMemory([this]() -> absl::Status {
      Response response;
      absl::Status status = Complete(&response);
      if (status.ok()) *response_ = SerializeMessage(response);
      return status;
    }));
  }

  void GiveUp() {
    if (ended_) return;
    ++host_.peer_bound_calls.faults().not_sending;
    End(absl::DeadlineExceededError(
        absl::StrFormat("the next message did not come within peer_timeout_ms, which is %d",
                        host_.limits.peer_timeout_ms.load())));
  }

  void End(const absl::Status& status) {
    WithinMemory([&] {
      host_.operations.Note(*context_, principal_, Request::descriptor(), first_request_, status);
    }).IgnoreError();
    Refuse(status);
  }

  void Refuse(const absl::Status& status) {
    if (ended_.exchange(true)) return;
    Release();
    this->Finish(ToGrpc(status));
  }

  const RpcContext& host_;
  grpc::CallbackServerContext* const context_;
  grpc::ByteBuffer* const response_;
  const OpenCalls::Token token_;
  Strand strand_;
  PeerWait peer_wait_;
  std::shared_ptr<ReadStream> self_;  ///< reset by OnDone
  grpc::ByteBuffer bytes_;            ///< the transport's while a read is under way
  Request request_;
  std::string first_request_;  ///< its text: what the call is about
  Principal principal_;
  std::atomic<bool> ended_ = false;
};

}  // namespace dcloc::server
