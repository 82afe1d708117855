#pragma once

#include <string>

#include "dcloc/v1/admin_service.grpc.pb.h"
#include "server/localization/session_registry.h"
#include "server/storage_host.h"

namespace dcloc::server {

/// What of the server's state does not change while it runs.
struct ServerFacts {
  std::string version;
  SystemTime start_time;
  int worker_count = 0;
  int max_session_count = 0;
  bool stub_matcher = false;
};

/// AdminService: looks, and changes nothing.
class AdminService final : public v1::AdminService::CallbackService {
 public:
  /// `registry` outlives the service's calls.
  AdminService(ServerFacts facts, SessionRegistry& registry, StorageHost host);

  grpc::ServerUnaryReactor* GetServerState(grpc::CallbackServerContext* context,
                                           const v1::GetServerStateRequest* request,
                                           v1::GetServerStateResponse* response) override;
  grpc::ServerUnaryReactor* ListSessions(grpc::CallbackServerContext* context,
                                         const v1::ListSessionsRequest* request,
                                         v1::ListSessionsResponse* response) override;

 private:
  const ServerFacts facts_;
  SessionRegistry& registry_;
  const StorageHost host_;
};

}  // namespace dcloc::server
