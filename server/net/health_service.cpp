#include "server/net/health_service.h"

#include <google/protobuf/wrappers.pb.h>
#include <grpcpp/server_context.h>
#include <grpcpp/support/proto_buffer_reader.h>
#include <grpcpp/support/proto_buffer_writer.h>

#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/str_format.h"
#include "server/base/status.h"

namespace dcloc::server {
namespace {

using Traits = grpc::SerializationTraits<google::protobuf::Int32Value>;

constexpr std::size_t kMaxName = 200;
constexpr const char* kCheck = "/grpc.health.v1.Health/Check";
constexpr const char* kWatch = "/grpc.health.v1.Health/Watch";

/// The service that a request names. A HealthCheckRequest has the form of a StringValue.
absl::StatusOr<std::string> NameOf(const grpc::ByteBuffer& request) {
  grpc::ByteBuffer bytes = request;
  google::protobuf::StringValue message;
  if (!grpc::SerializationTraits<google::protobuf::StringValue>::Deserialize(&bytes, &message)
           .ok()) {
    return absl::InvalidArgumentError(
        "the message does not parse as grpc.health.v1.HealthCheckRequest");
  }
  if (message.value().size() > kMaxName) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "service has %d bytes; it must have at most %d", message.value().size(), kMaxName));
  }
  return std::move(*message.mutable_value());
}

}  // namespace

/// One call of Watch: it is told each change, the last one if it reads slowly.
class HealthService::Watcher final : public grpc::ServerWriteReactor<grpc::ByteBuffer>,
                                     public std::enable_shared_from_this<Watcher> {
 public:
  Watcher(HealthService& service, grpc::CallbackServerContext& context, std::string name)
      : service_(service), context_(context), name_(std::move(name)) {}

  const std::string& name() const { return name_; }

  void TellChange() {
    const std::lock_guard lock(mutex_);
    if (ending_ || writing_) return;
    const Status status = service_.StatusNow(name_);
    if (told_ == status) return;
    told_ = status;
    writing_ = true;
    message_ = Message(status);
    StartWrite(&message_);
  }

  /// Ends it, after the write under way.
  void End(grpc::Status status) {
    const std::lock_guard lock(mutex_);
    if (ending_) return;
    ending_ = std::move(status);
    if (!writing_) Finish(std::move(*ending_));  // a copy takes memory
  }

  /// Ends it now: a write that nobody reads fails.
  void Cut(grpc::Status status) {
    End(std::move(status));
    const std::lock_guard lock(mutex_);
    if (writing_) context_.TryCancel();
  }

  void OnWriteDone(bool ok) override {
    {
      const std::lock_guard lock(mutex_);
      writing_ = false;
      if (!ok && !ending_) ending_ = grpc::Status::CANCELLED;
      if (ending_) return Finish(std::move(*ending_));
    }
    TellChange();
  }

  void OnCancel() override { End(grpc::Status::CANCELLED); }

  void OnDone() override { service_.Forget(*this); }

 private:
  HealthService& service_;
  grpc::CallbackServerContext& context_;
  const std::string name_;
  std::mutex mutex_;  ///< taken before the service's
  std::optional<Status> told_;
  bool writing_ = false;
  std::optional<grpc::Status> ending_;  ///< what it ends with
  grpc::ByteBuffer message_;            ///< the transport's while it is written
};

HealthService::HealthService(AwaitedRequests& requests, std::function<WaitingBounds()> bounds)
    : bounds_(std::move(bounds)) {
  const auto add = [&](const char* path, std::unique_ptr<grpc::internal::MethodHandler> handler) {
    auto method = std::make_unique<grpc::internal::RpcServiceMethod>(
        path, grpc::internal::RpcMethod::BIDI_STREAMING,
        requests.Awaiting(std::move(handler)).release());
    method->SetServerApiType(grpc::internal::RpcServiceMethod::ApiType::CALL_BACK);
    AddMethod(method.release());
  };
  add(kCheck,
      std::make_unique<grpc::internal::CallbackUnaryHandler<grpc::ByteBuffer, grpc::ByteBuffer>>(
          [this](grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                 grpc::ByteBuffer* response) { return Check(context, request, response); }));
  add(kWatch,
      std::make_unique<
          grpc::internal::CallbackServerStreamingHandler<grpc::ByteBuffer, grpc::ByteBuffer>>(
          [this](grpc::CallbackServerContext* context, const grpc::ByteBuffer* request) {
            return Watch(context, request);
          }));
}

HealthService::~HealthService() = default;

void HealthService::SetServing(const std::string& name, bool serving) {
  {
    const std::lock_guard lock(mutex_);
    serving_[name] = serving && !shut_down_;
  }
  for (const auto& watcher : Watchers()) {
    if (watcher->name() == name) watcher->TellChange();
  }
}

void HealthService::Shutdown() {
  {
    const std::lock_guard lock(mutex_);
    shut_down_ = true;
    for (auto& [name, serving] : serving_) serving = false;
  }
  for (const auto& watcher : Watchers()) {
    watcher->End({grpc::StatusCode::UNAVAILABLE, "the server is shutting down"});
  }
}

int HealthService::watcher_count() const {
  const std::lock_guard lock(mutex_);
  return oldest_first_.count();
}

grpc::ServerUnaryReactor* HealthService::Check(grpc::CallbackServerContext* context,
                                               const grpc::ByteBuffer* request,
                                               grpc::ByteBuffer* response) {
  const absl::StatusOr<std::string> name = NameOf(*request);
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  const Status status = name.ok() ? StatusNow(*name) : Status::kServiceUnknown;
  if (!name.ok()) {
    reactor->Finish(ToGrpc(name.status()));
  } else if (status == Status::kServiceUnknown) {
    reactor->Finish({grpc::StatusCode::NOT_FOUND, "there is no service " + Quoted(*name)});
  } else {
    *response = Message(status);
    reactor->Finish(grpc::Status::OK);
  }
  return reactor;
}

grpc::ServerWriteReactor<grpc::ByteBuffer>* HealthService::Watch(
    grpc::CallbackServerContext* context, const grpc::ByteBuffer* request) {
  const absl::StatusOr<std::string> name = NameOf(*request);
  auto watcher = std::make_shared<Watcher>(*this, *context, name.value_or(""));
  std::shared_ptr<Watcher> crowded_out;
  std::string reason;
  bool ending = false;
  {
    const std::lock_guard lock(mutex_);
    ending = shut_down_;
    watchers_[watcher.get()] = watcher;
    if (auto excess = oldest_first_.Add(watcher.get(), AddressOf(context->peer()), bounds_())) {
      crowded_out = watchers_.at(excess->call);
      reason = std::move(excess->reason);
    }
  }
  if (crowded_out != nullptr) {
    crowded_out->Cut({grpc::StatusCode::RESOURCE_EXHAUSTED, reason});
  }
  if (!name.ok()) watcher->End(ToGrpc(name.status()));
  if (ending) watcher->End({grpc::StatusCode::UNAVAILABLE, "the server is shutting down"});
  watcher->TellChange();
  return watcher.get();
}

grpc::ByteBuffer HealthService::Message(Status status) {
  // A HealthCheckResponse has the form of an Int32Value.
  google::protobuf::Int32Value message;
  message.set_value(static_cast<int>(status));
  grpc::ByteBuffer bytes;
  bool own = false;
  Traits::Serialize(message, &bytes, &own);
  return bytes;
}

HealthService::Status HealthService::StatusNow(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  const auto found = serving_.find(name);
  if (found == serving_.end()) return Status::kServiceUnknown;
  return found->second ? Status::kServing : Status::kNotServing;
}

std::vector<std::shared_ptr<HealthService::Watcher>> HealthService::Watchers() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::shared_ptr<Watcher>> watchers;
  watchers.reserve(watchers_.size());
  for (const auto& [address, watcher] : watchers_) watchers.push_back(watcher);
  return watchers;
}

void HealthService::Forget(Watcher& watcher) {
  std::shared_ptr<Watcher> last;  // goes after the lock
  const std::lock_guard lock(mutex_);
  oldest_first_.Remove(&watcher);
  const auto found = watchers_.find(&watcher);
  last = std::move(found->second);
  watchers_.erase(found);
}

}  // namespace dcloc::server
