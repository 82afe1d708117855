#pragma once

#include <grpcpp/impl/service_type.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/base/waiting_calls.h"
#include "server/net/awaited_requests.h"

namespace dcloc::server {

/// `grpc.health.v1.Health`, which everybody may ask. gRPC's own lets a peer hold as many calls as
/// it likes; here requests are awaited, and those who watch are bounded. Thread-safe.
class HealthService final : public grpc::Service {
 public:
  /// `requests` outlives this and its calls. `bounds` is asked for each caller that watches.
  HealthService(AwaitedRequests& requests, std::function<WaitingBounds()> bounds);
  ~HealthService() override;

  /// Whether a service, or the server under the empty name, serves. One that was never set is
  /// unknown.
  void SetServing(const std::string& name, bool serving);

  /// Nothing serves any more, and those who watch are ended.
  void Shutdown();

  int watcher_count() const;

 private:
  class Watcher;
  enum class Status { kServing = 1, kNotServing = 2, kServiceUnknown = 3 };

  grpc::ServerUnaryReactor* Check(grpc::CallbackServerContext* context,
                                  const grpc::ByteBuffer* request, grpc::ByteBuffer* response);
  grpc::ServerWriteReactor<grpc::ByteBuffer>* Watch(grpc::CallbackServerContext* context,
                                                    const grpc::ByteBuffer* request);

  static grpc::ByteBuffer Message(Status status);
  Status StatusNow(const std::string& name) const;
  std::vector<std::shared_ptr<Watcher>> Watchers() const;
  void Forget(Watcher& watcher);

  const std::function<WaitingBounds()> bounds_;
  mutable std::mutex mutex_;
  std::map<std::string, bool> serving_;
  std::map<Watcher*, std::shared_ptr<Watcher>> watchers_;
  WaitingCalls<Watcher> oldest_first_{"watch health"};
  bool shut_down_ = false;
};

}  // namespace dcloc::server
