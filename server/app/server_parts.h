#pragma once

#include <grpcpp/server.h>

#include <chrono>
#include <latch>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/admin/admin_service.h"
#include "server/app/server.h"
#include "server/app/storage.h"
#include "server/base/ticker.h"
#include "server/config/credentials.h"
#include "server/identity/usage.h"
#include "server/localization/localization_service.h"
#include "server/maps/service/map_service.h"
#include "server/maps/service/pass_service.h"
#include "server/maps/store/map_scrub.h"
#include "server/net/awaited_requests.h"
#include "server/net/bounded_calls.h"
#include "server/net/health.h"
#include "server/net/health_service.h"
#include "server/net/listen_address.h"
#include "server/net/listener.h"
#include "server/net/liveness.h"
#include "server/net/readiness.h"
#include "server/passes/pass_writer.h"
#include "server/sessions/canary_watch.h"
#include "server/telemetry/metrics_endpoint.h"

namespace dcloc::server {

/// What a server is made of, in the order in which it is built; it goes in the reverse one. The
/// pools go before what their tasks use.
struct Server::Parts {
  Parts(const ServerConfig& server_config, RegistrationMethods registration, Storage opened,
        std::shared_ptr<CallGate> call_gate,
        std::shared_ptr<ServedCertificates> served_certificates,
        std::unique_ptr<SessionTickets> fleet_tickets);

  /// Binds, and begins to answer calls.
  absl::Status Serve(const std::shared_ptr<grpc::ServerCredentials>& credentials);

  /// Not ready any more; at `notice_end` new sessions are refused, and those that are there are
  /// told to move and have `grace` for it. Gives how many these are now.
  int BeginDrain(std::chrono::steady_clock::time_point notice_end, std::chrono::milliseconds grace);

  /// Why not, or what there is to say.
  absl::StatusOr<std::string> Ready() const;

  ServerGauges Gauges() const;
  ScanLocalizerFactory MakeLocalizerFactory();
  SessionContext MakeSessionContext();
  SessionDrainer MakeSessionDrainer();

  /// Not ready while it does not answer its own connections.
  void WatchItself(const ListenAddress& listen);

  /// Takes new certificates, and says so when those that are shown have expired.
  void WatchCertificates();

  absl::Status ServeMetrics();

  /// How many calls may wait for their first message.
  WaitingBounds UnopenedBounds() const;

  /// Ends sessions, calls and streams whose time is over.
  void EndOverdue();

  /// Tends the process' reserve of memory, and says when it is given and taken again.
  void TellOfMemory();

  /// How much of passes is kept, and for how long, at this moment.
  PassBounds PassBoundsNow() const;

  void RemoveExpiredPasses();

  /// Looks at vehicles in canaries, and judges these now and then.
  void WatchCanaries();

  /// Removes unfinished uploads, what was long enough in quarantine, and passes whose time is over.
  void Sweep();

  ServerConfig config;
  const RegistrationMethods methods;
  const std::chrono::milliseconds drain_notice;
  const std::chrono::milliseconds drain_grace;
  const std::shared_ptr<CallGate> gate;
  std::shared_ptr<ServedCertificates> certificates;  ///< null without TLS
  std::unique_ptr<SessionTickets> tickets;           ///< null without fleet keys
  Limits limits;
  UsageCounts usages{limits};
  Storage opened_storage;
  AccessControl access;
  MapStore& store;
  PassWriter passes;
  WorkspacePool workspaces;
  SessionRegistry registry;
  SessionMetrics metrics;
  RecordingRequests recordings;
  OperationLog operations;
  OpenCalls open_calls;
  PeerBoundCalls peer_bound_calls;
  AwaitedRequests awaited_requests;
  BoundedCalls bounded_calls;
  HealthService health_service;
  WorkerPool storage_pool;
  Replicas replicas;
  const RpcContext rpc_context{store,  storage_pool, open_calls, peer_bound_calls, awaited_requests,
                               access, operations,   limits};
  WorkerPool localization_pool;
  LocalizationService localization;
  MapService maps;
  PassService pass_service;
  AdminService admin;
  std::unique_ptr<grpc::Server> server;
  std::unique_ptr<Health> health;
  std::latch server_is_set{1};  ///< the first calls may be there before it
  std::unique_ptr<Listener> listener;
  std::unique_ptr<Liveness> liveness;
  std::unique_ptr<Ticker> liveness_ticker;
  std::unique_ptr<Ticker> certificate_ticker;
  std::unique_ptr<Readiness> readiness;
  std::unique_ptr<Ticker> readiness_ticker;
  std::unique_ptr<HttpPages> metrics_pages;
  CanaryWatch canary_watch{registry, store};
  int canary_look_count = 0;
  std::unique_ptr<Ticker> canary_ticker;  ///< null where worse canaries are kept
  bool memory_is_short = false;           ///< as it was told last
  Ticker ticker;
  MapScrub scrub;
  std::chrono::steady_clock::time_point last_sweep = std::chrono::steady_clock::now();
  int sweep_count = 0;
  Ticker sweeper;
  std::string address;
};

}  // namespace dcloc::server
