#pragma once

#include <grpcpp/support/server_callback.h>

#include <chrono>
#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <utility>

#include "absl/status/status.h"
#include "server/base/status.h"
#include "server/base/within_memory.h"
#include "server/rpc/rpc_context.h"

namespace dcloc::server {

/// A call that streams messages to its caller, in order. Pushing never waits: messages are queued,
/// and a derived class decides what happens when the queue is full. A caller who does not read for
/// `peer_timeout_ms` is cut off. Thread-safe.
template <typename Message>
class PushStream : public grpc::ServerWriteReactor<Message>, public PeerBoundCall {
 public:
  void OnWriteDone(bool ok) override {
    const std::lock_guard lock(mutex_);
    write_under_way_ = false;
    peer_wait_.End();
    if (!ok) EndLocked(grpc::Status::CANCELLED);
    Pump();
  }

  void OnCancel() override { End(grpc::Status(grpc::StatusCode::CANCELLED, "cancelled")); }

  void CheckPeer(PeerWait::Clock::time_point now) override {
    const std::lock_guard lock(mutex_);
    if (state_ == State::kFinished || !peer_wait_.TakeOverdue(now)) return;
    ++host_.peer_bound_calls.faults().not_reading;
    context_->TryCancel();
  }

  void OnDone() override { const std::shared_ptr<PushStream> last = std::move(self_); }

  /// Runs `work` on the pool, whose last step decides whether the call may proceed. Without memory
  /// the call ends.
  template <typename Work>
  void BeginOnPool(Work work) {
    const absl::Status posted = WithinMemory([&] {
      host_.pool.Post([self = self_, work = std::move(work)] {
        const absl::Status done = WithinMemory(work);
        if (!done.ok()) self->BeginWith(done);
      });
    });
    if (!posted.ok()) BeginWith(posted);
  }

 protected:
  /// Of a call that ends because this server does; it can be made again at another one.
  static grpc::Status Stopping() {
    return {grpc::StatusCode::UNAVAILABLE, "the server is shutting down"};
  }

  PushStream(const RpcContext& host, grpc::CallbackServerContext* context)
      : host_(host), context_(context), token_(host.open_calls) {}

  /// Lives from here until the call is done and others have let go of it.
  template <typename Stream>
  static std::shared_ptr<Stream> Hold(std::shared_ptr<Stream> stream) {
    PushStream& base = *stream;
    base.host_.peer_bound_calls.Add(stream);
    base.self_ = stream;
    return stream;
  }

  /// To be called when it is decided whether the call may proceed. With OK the initial metadata is
  /// sent; with an error the call ends. Nothing is written before.
  void BeginWith(const absl::Status& status) {
    const std::lock_guard lock(mutex_);
    if (!status.ok()) EndLocked(ToGrpc(status));
    begin_under_way_ = false;
    if (state_ == State::kOpen) this->StartSendInitialMetadata();
    Pump();
  }

  /// Ends the call: with OK once all queued messages are written, with an error at once.
  void End(grpc::Status status) {
    const std::lock_guard lock(mutex_);
    EndLocked(std::move(status));
    Pump();
  }

  // With the mutex held from here on.

  /// Before `message` is written, and before the call is finished.
  virtual void OnWrite(Message& /*message*/) {}
  virtual void OnFinish() {}

  bool is_open() const { return state_ == State::kOpen; }

  /// The first error is kept, also after an end with OK.
  void EndLocked(grpc::Status status) {
    if (!status.ok()) waiting_.clear();
    if (state_ == State::kOpen || end_status_.ok()) end_status_ = std::move(status);
    if (state_ == State::kOpen) state_ = State::kEnding;
  }

  void Pump() {
    if (begin_under_way_ || write_under_way_ || state_ == State::kFinished) return;
    if (!waiting_.empty()) {
      message_ = std::move(waiting_.front());
      waiting_.pop_front();
      OnWrite(message_);
      write_under_way_ = true;
      peer_wait_.Begin(std::chrono::milliseconds(host_.limits.peer_timeout_ms));
      this->StartWrite(&message_);
    } else if (state_ == State::kEnding) {
      state_ = State::kFinished;
      OnFinish();
      this->Finish(std::move(end_status_));  // a copy takes memory
    }
  }

  std::mutex mutex_;
  std::deque<Message> waiting_;

 private:
  enum class State { kOpen, kEnding, kFinished };

  std::shared_ptr<PushStream> self_;  ///< reset by OnDone
  const RpcContext& host_;
  grpc::CallbackServerContext* const context_;
  const OpenCalls::Token token_;
  PeerWait peer_wait_;
  State state_ = State::kOpen;
  bool begin_under_way_ = true;  ///< a task may use the call's context and request
  bool write_under_way_ = false;
  Message message_;          ///< the transport's while a write is under way
  grpc::Status end_status_;  ///< from kEnding on
};

}  // namespace dcloc::server
