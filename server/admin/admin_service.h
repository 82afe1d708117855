#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "dcloc/v1/admin_service.grpc.pb.h"
#include "server/admin/record_stream.h"
#include "server/admin/watch_stream.h"
#include "server/base/shutdown_hooks.h"
#include "server/net/awaiting_service.h"
#include "server/replicas/replicas.h"
#include "server/rpc/rpc_context.h"
#include "server/rpc/unary.h"
#include "server/sessions/recording_subscriber.h"
#include "server/sessions/session_registry.h"

namespace dcloc::server {

/// The part of the server's state that does not change while it runs.
struct ServerFacts {
  std::string version;
  SystemTime start_time;
  int worker_count = 0;
  bool stub_localizer = false;
};

/// The part that does, beside sessions and maps.
struct ServerGauges {
  int unopened_stream_count = 0;
  int awaited_request_count = 0;
  int max_unopened_stream_count = 0;
  std::optional<SystemTime> certificate_expire_time;  ///< none without TLS
  std::string certificate_fault;
};

/// How to empty the server.
struct DrainControl {
  std::function<int()> drain;      ///< returns how many sessions were told to move
  std::function<bool()> draining;  ///< whether it was called
};

/// AdminService: the operators' RPCs: state, sessions and drain of all replicas, identities, and
/// what was changed here.
class AdminService final : public AwaitingService<v1::AdminService::CallbackService> {
 public:
  /// The references outlive the service's calls.
  AdminService(ServerFacts facts, SessionRegistry& registry, RecordingRequests& recordings,
               IdentityStore& identities, RpcContext host, Replicas& replicas, DrainControl drain,
               std::function<ServerGauges()> gauges);

  grpc::ServerUnaryReactor* ListReplicas(grpc::CallbackServerContext* context,
                                         const v1::ListReplicasRequest* request,
                                         v1::ListReplicasResponse* response) override;
  grpc::ServerUnaryReactor* GetServerState(grpc::CallbackServerContext* context,
                                           const v1::GetServerStateRequest* request,
                                           v1::GetServerStateResponse* response) override;
  grpc::ServerUnaryReactor* ListSessions(grpc::CallbackServerContext* context,
                                         const v1::ListSessionsRequest* request,
                                         v1::ListSessionsResponse* response) override;
  grpc::ServerUnaryReactor* GetSession(grpc::CallbackServerContext* context,
                                       const v1::GetSessionRequest* request,
                                       v1::GetSessionResponse* response) override;
  grpc::ServerUnaryReactor* EndSession(grpc::CallbackServerContext* context,
                                       const v1::EndSessionRequest* request,
                                       v1::EndSessionResponse* response) override;
  grpc::ServerWriteReactor<v1::WatchSessionResponse>* WatchSession(
      grpc::CallbackServerContext* context, const v1::WatchSessionRequest* request) override;
  grpc::ServerWriteReactor<v1::RecordSessionResponse>* RecordSession(
      grpc::CallbackServerContext* context, const v1::RecordSessionRequest* request) override;
  grpc::ServerUnaryReactor* ProposePose(grpc::CallbackServerContext* context,
                                        const v1::ProposePoseRequest* request,
                                        v1::ProposePoseResponse* response) override;
  grpc::ServerUnaryReactor* ListOperations(grpc::CallbackServerContext* context,
                                           const v1::ListOperationsRequest* request,
                                           v1::ListOperationsResponse* response) override;
  grpc::ServerUnaryReactor* ListIdentities(grpc::CallbackServerContext* context,
                                           const v1::ListIdentitiesRequest* request,
                                           v1::ListIdentitiesResponse* response) override;
  grpc::ServerUnaryReactor* RevokeIdentity(grpc::CallbackServerContext* context,
                                           const v1::RevokeIdentityRequest* request,
                                           v1::RevokeIdentityResponse* response) override;
  grpc::ServerUnaryReactor* Drain(grpc::CallbackServerContext* context,
                                  const v1::DrainRequest* request,
                                  v1::DrainResponse* response) override;

  /// Ends, for a stop, the streams whose end would not come with that of this server's sessions:
  /// those of other servers' sessions, and recordings whose vehicle has not come.
  void EndWaiting() { shutdown_hooks_.RunAll(); }

 private:
  WatchStream* BeginWatching(grpc::CallbackServerContext* context,
                             const v1::WatchSessionRequest* request);
  RecordStream* BeginRecording(grpc::CallbackServerContext* context,
                               const v1::RecordSessionRequest* request);
  void Describe(v1::GetServerStateResponse* response) const;

  /// Those that a call about one session is handed on to; none where the caller cannot be spoken
  /// for.
  std::vector<std::string> OthersToAsk(const grpc::CallbackServerContext& context) const;

  /// Hands a call on about a session that is not here, as `here` says: `done` is told what the
  /// replica that has it answered.
  template <typename Request, typename Response>
  void AskOwner(const grpc::CallbackServerContext& context, const Request& request,
                Replicas::Method<Request, Response> method, const absl::Status& here,
                Response* response, const UnaryDone& done);

  /// Hands a call on to the replica of that address, which has until `bound`.
  template <typename Request, typename Response>
  void AskOne(std::string address, const grpc::CallbackServerContext& context,
              const Request& request, Replicas::Method<Request, Response> method,
              std::chrono::milliseconds bound, Response* response, const UnaryDone& done);

  /// Watches a session that is not here; `here` says why. `request` lives until `Begin`.
  void WatchElsewhere(grpc::CallbackServerContext* context, const v1::WatchSessionRequest& request,
                      const absl::Status& here, const std::shared_ptr<WatchStream>& stream);

  const ServerFacts facts_;
  SessionRegistry& registry_;
  RecordingRequests& recordings_;
  IdentityStore& identities_;
  RecordingSlots recording_slots_;
  const RpcContext host_;
  Replicas& replicas_;
  const DrainControl drain_;
  const std::function<ServerGauges()> gauges_;
  ShutdownHooks shutdown_hooks_;
};

}  // namespace dcloc::server
