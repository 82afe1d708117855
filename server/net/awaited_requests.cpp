#include "server/net/awaited_requests.h"

#include <grpcpp/server_context.h>

#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "server/base/status.h"
#include "server/base/within_memory.h"

namespace dcloc::server {

using HandlerParameter = grpc::internal::MethodHandler::HandlerParameter;

namespace {

/// Keeps a call of gRPC's core, and cancels it without a lock held: what waits for it may run on
/// this thread.
class Cancellation {
 public:
  Cancellation(grpc_call* call, grpc_status_code code, std::string reason)
      : call_(call), code_(code), reason_(std::move(reason)) {
    grpc_call_ref(call);
  }
  Cancellation(Cancellation&& other) noexcept
      : call_(std::exchange(other.call_, nullptr)),
        code_(other.code_),
        reason_(std::move(other.reason_)) {}
  Cancellation& operator=(Cancellation&&) = delete;
  ~Cancellation() {
    if (call_ == nullptr) return;
    grpc_call_cancel_with_status(call_, code_, reason_.c_str(), nullptr);
    grpc_call_unref(call_);
  }

 private:
  grpc_call* call_;
  grpc_status_code code_;
  std::string reason_;
};

/// Hands a call on to its handler with the request, or without one; then the handler's call fails,
/// as gRPC's own does. One that gets no memory for the request says so.
void HandOn(grpc::internal::MethodHandler& handler, const HandlerParameter& parameter,
            grpc_byte_buffer* bytes) {
  grpc_call* const call = parameter.call->call();
  grpc::Status status;
  void* data = nullptr;
  void* request = nullptr;
  const absl::Status parsed =
      WithinMemory([&] { request = handler.Deserialize(call, bytes, &status, &data); });
  if (!parsed.ok()) {
    status = ToGrpc(parsed);
    grpc_call_cancel_with_status(call, GRPC_STATUS_RESOURCE_EXHAUSTED, "out of memory", nullptr);
  }
  handler.RunHandler(
      {parameter.call, parameter.server_context, request, status, data, parameter.call_requester});
}

}  // namespace

/// A call that waits for its request. Deletes itself when that is there, or will not come.
class AwaitedRequests::Call : private grpc_completion_queue_functor {
 public:
  Call(AwaitedRequests& keeper, grpc::internal::MethodHandler& handler,
       const HandlerParameter& parameter, Clock::time_point deadline)
      : grpc_completion_queue_functor{},
        keeper_(keeper),
        handler_(handler),
        parameter_(parameter),
        deadline_(deadline) {
    functor_run = [](grpc_completion_queue_functor* functor, int /*ok*/) {
      static_cast<Call*>(functor)->OnRead();
    };
  }

  grpc_call* call() const { return parameter_.call->call(); }
  std::string peer() const { return parameter_.server_context->peer(); }
  Clock::time_point deadline() const { return deadline_; }

  void Read() {
    grpc_op receive{};
    receive.op = GRPC_OP_RECV_MESSAGE;
    receive.data.recv_message.recv_message = &request_;
    grpc_call_ref(call());
    grpc_completion_queue_functor* const tag = this;
    grpc_call_start_batch(call(), &receive, 1, tag, nullptr);
  }

 private:
  void OnRead() {
    const std::unique_ptr<Call> self(this);
    keeper_.Forget(*this);
    grpc_call* const call = this->call();
    HandOn(handler_, parameter_, request_);
    grpc_call_unref(call);
  }

  AwaitedRequests& keeper_;
  grpc::internal::MethodHandler& handler_;
  const HandlerParameter parameter_;
  const Clock::time_point deadline_;
  grpc_byte_buffer* request_ = nullptr;
};

class AwaitedRequests::Handler final : public grpc::internal::MethodHandler {
 public:
  Handler(AwaitedRequests& keeper, std::unique_ptr<MethodHandler> handler)
      : keeper_(keeper), handler_(std::move(handler)) {}

  void RunHandler(const HandlerParameter& parameter) override {
    std::unique_ptr<Call> call;
    const absl::Status begun = WithinMemory([&] {
      call = std::make_unique<Call>(keeper_, *handler_, parameter,
                                    Clock::now() + keeper_.bounds_().time);
      keeper_.Begin(*call);
    });
    if (begun.ok()) return call.release()->Read();
    if (call != nullptr) keeper_.Forget(*call);
    grpc_call_cancel_with_status(parameter.call->call(), GRPC_STATUS_RESOURCE_EXHAUSTED,
                                 "out of memory", nullptr);
    HandOn(*handler_, parameter, nullptr);
  }

 private:
  AwaitedRequests& keeper_;
  const std::unique_ptr<MethodHandler> handler_;
};

std::unique_ptr<grpc::internal::MethodHandler> AwaitedRequests::Awaiting(
    std::unique_ptr<grpc::internal::MethodHandler> handler) {
  return std::make_unique<Handler>(*this, std::move(handler));
}

int AwaitedRequests::count() const {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(calls_.size());
}

void AwaitedRequests::Begin(Call& call) {
  const WaitingBounds bounds = bounds_().count;
  const std::string address = AddressOf(call.peer());
  std::optional<Cancellation> excess;
  {
    const std::lock_guard lock(mutex_);
    calls_.insert(&call);
    if (auto oldest = waiting_.Add(&call, address, bounds)) {
      calls_.erase(oldest->call);
      excess.emplace(oldest->call->call(), GRPC_STATUS_RESOURCE_EXHAUSTED,
                     std::move(oldest->reason));
      ++faults_.too_many_waiting;
    }
  }
}

void AwaitedRequests::Forget(Call& call) {
  const std::lock_guard lock(mutex_);
  calls_.erase(&call);
  waiting_.Remove(&call);
}

void AwaitedRequests::EndOverdue(Clock::time_point now) {
  std::vector<Cancellation> overdue;
  const auto reason = [this] {
    return absl::StrFormat("the request did not come within open_timeout_ms, which is %d",
                           bounds_().time.count());
  };
  const std::lock_guard lock(mutex_);
  std::erase_if(calls_, [&](Call* call) {
    if (now <= call->deadline()) return false;
    waiting_.Remove(call);
    overdue.emplace_back(call->call(), GRPC_STATUS_DEADLINE_EXCEEDED, reason());
    ++faults_.not_sending;
    return true;
  });
}

}  // namespace dcloc::server
