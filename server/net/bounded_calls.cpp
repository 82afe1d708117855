#include "server/net/bounded_calls.h"

#include <new>
#include <utility>

#include "absl/strings/match.h"
#include "server/base/within_memory.h"

namespace dcloc::server {
namespace {

/// So that the end of thousands of calls holds up no vehicle.
constexpr int kMaxEndedAtOnce = 200;

}  // namespace

/// Lives as long as its call's context.
class BoundedCalls::Call final : public grpc::experimental::Interceptor {
 public:
  Call(BoundedCalls& keeper, grpc::ServerContextBase& context, bool is_reflection)
      : keeper_(keeper), context_(context), is_reflection_(is_reflection) {
    if (is_reflection) Bound(keeper_.times_().reflection);
  }
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;
  ~Call() override {
    const std::lock_guard lock(keeper_.mutex_);
    keeper_.deadlines_.erase(this);
  }

  void Intercept(grpc::experimental::InterceptorBatchMethods* batch) override {
    if (!is_reflection_ && batch->QueryInterceptionHookPoint(
                               grpc::experimental::InterceptionHookPoints::PRE_SEND_STATUS)) {
      Bound(keeper_.times_().reading);
    }
    batch->Proceed();
  }

  void End() {
    if (!is_reflection_) ++keeper_.faults_.not_reading;
    context_.TryCancel();
  }

 private:
  /// Without memory it is not bounded; that passes.
  void Bound(std::chrono::milliseconds time) {
    const std::lock_guard lock(keeper_.mutex_);
    WithinMemory([&] { keeper_.deadlines_[this] = Clock::now() + time; }).IgnoreError();
  }

  BoundedCalls& keeper_;
  grpc::ServerContextBase& context_;
  const bool is_reflection_;
};

class BoundedCalls::Factory final : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  explicit Factory(BoundedCalls& keeper) : keeper_(keeper) {}

  grpc::experimental::Interceptor* CreateServerInterceptor(
      grpc::experimental::ServerRpcInfo* info) override {
    const absl::string_view path = info->method();
    if (absl::StartsWith(path, "/dcloc.v1.LocalizationService/")) return nullptr;
    return new (std::nothrow)
        Call(keeper_, *info->server_context(), absl::StartsWith(path, "/grpc.reflection."));
  }

 private:
  BoundedCalls& keeper_;
};

std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> BoundedCalls::Watching() {
  return std::make_unique<Factory>(*this);
}

void BoundedCalls::EndOverdue(Clock::time_point now) {
  // With the lock: a call's end waits for it. It is ended by another thread, which this one wakes.
  const std::lock_guard lock(mutex_);
  int ended = 0;
  for (auto& [call, deadline] : deadlines_) {
    if (ended == kMaxEndedAtOnce) return;
    if (now <= deadline) continue;
    ++ended;
    call->End();
    deadline = Clock::time_point::max();
  }
}

}  // namespace dcloc::server
