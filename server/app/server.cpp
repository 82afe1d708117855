#include "server/app/server.h"

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>

#include <algorithm>
#include <latch>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "core/localizer/workspace.h"
#include "server/admin/admin_service.h"
#include "server/app/access_notice.h"
#include "server/app/part_options.h"
#include "server/app/state_metrics.h"
#include "server/app/storage.h"
#include "server/app/transport.h"
#include "server/base/status.h"
#include "server/base/ticker.h"
#include "server/config/credentials.h"
#include "server/identity/usage.h"
#include "server/localization/localization_service.h"
#include "server/maps/service/map_service.h"
#include "server/maps/store/map_scrub.h"
#include "server/net/health.h"
#include "server/net/listen_address.h"
#include "server/net/listener.h"
#include "server/net/liveness.h"
#include "server/net/readiness.h"
#include "server/net/self_probe.h"
#include "server/net/service_manager.h"
#include "server/sessions/move_sessions.h"
#include "server/telemetry/metrics_endpoint.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

/// What waits for a disk needs few threads; what reads whole maps has its own, which take the
/// processor after those that localize.
constexpr int kStorageThreads = 2;
constexpr int kMapThreads = 2;

constexpr std::chrono::milliseconds kLastBytesGrace(200);
constexpr std::chrono::seconds kSelfProbeTimeout(3);
constexpr std::chrono::milliseconds kReadyTimeout(800);
constexpr std::chrono::milliseconds kReadyInterval(500);  ///< of asking whether it is ready
constexpr std::chrono::seconds kCertificateInterval(1);   ///< of looking at the files
constexpr std::chrono::milliseconds kTickInterval(100);   ///< of timeouts of sessions
constexpr std::chrono::minutes kSweepInterval(1);  ///< of unfinished uploads and the quarantine

void LogRemoved(const char* what, const absl::StatusOr<int>& count) {
  if (!count.ok()) {
    spdlog::warn("{} not removed reason={}", what, Quoted(count.status().message()));
  } else if (*count > 0) {
    spdlog::info("{} removed count={}", what, *count);
  }
}

}  // namespace

/// In the order in which they are built; they go in the reverse one. The pools go before what their
/// tasks use.
struct Server::Parts {
  Parts(const ServerConfig& server_config, RegistrationMethods registration, Storage opened,
        std::shared_ptr<CallGate> call_gate,
        std::shared_ptr<ServedCertificates> served_certificates,
        std::unique_ptr<SessionTickets> fleet_tickets)
      : config(server_config),
        methods(std::move(registration)),
        drain_grace(config.drain_grace_ms),
        gate(std::move(call_gate)),
        certificates(std::move(served_certificates)),
        tickets(std::move(fleet_tickets)),
        limits(config),
        kept(std::move(opened)),
        access(*kept.identities, config.require_identity),
        store(*kept.maps),
        registry(limits, SessionTimeoutsOf(config)),
        replicas({.directory = kept.replicas.get(), .access = access, .pool = storage_pool},
                 ReplicaTlsOf(config),
                 {.answer = std::chrono::milliseconds(config.replica_timeout_ms)}),
        localization_pool(WorkerCount(config), SearcherCount(config)),
        localization({.storage = storage,
                      .registry = registry,
                      .sessions = {.store = store,
                                   .recordings = recordings,
                                   .context = MakeSessionContext()},
                      .usages = usages,
                      .max_pending_scan_count = config.max_pending_scan_count}),
        maps(storage,
             [this](const std::string& tenant, const std::string& map_name) {
               return MoveSessions(registry, store, tenant, map_name);
             },
             {.move_or_end =
                  [this](const std::string& tenant, const std::string& map_name,
                         std::int64_t version) {
                    MoveSessions(registry, store, tenant, map_name, version);
                    EndSessions(registry, tenant, map_name, version, EndOf::kThoseThatStay);
                  },
              .end_all =
                  [this](const std::string& tenant, const std::string& map_name,
                         std::int64_t version) {
                    EndSessions(registry, tenant, map_name, version, EndOf::kAll);
                  }}),
        admin({.version = DCLOC_VERSION,
               .start_time = std::chrono::system_clock::now(),
               .worker_count = localization_pool.thread_count(),
               .stub_matcher = config.stub_matcher},
              registry, recordings, *kept.identities, storage, replicas,
              {.drain = [this] { return Drain(drain_grace); },
               .draining = [this] { return localization.draining(); }},
              [this] { return Gauges(); }),
        ticker(kTickInterval,
               [this] {
                 const auto now = std::chrono::steady_clock::now();
                 registry.Reap(now);
                 peer_bound_calls.Check(now);
                 if (access.needs_proof()) gate->SetProofNeeded(true);
                 if (!localization.EndOverdue(now)) return;
                 // Nobody can resume them here any more.
                 registry.RemoveDetached("the server is draining");
               }),
        scrub(store.catalogue(), store.files(), {.max_bytes_per_s = 1e6 * config.scrub_mb_per_s}),
        sweeper(kSweepInterval, [this, last = std::chrono::steady_clock::now()]() mutable {
          const auto begin = std::exchange(last, std::chrono::steady_clock::now());
          LogRemoved("stale uploads", store.RemoveStaleUploads(last - begin));
          LogRemoved("files in quarantine", store.RemoveExpiredQuarantine(last - begin));
        }) {
    // The pools' threads are older than what they will use of this; their locks hand it to them.
    storage_pool.Post([] {});
    localization_pool.Post([] {});
  }

  ServerGauges Gauges() const {
    ServerGauges gauges{.unopened_stream_count = localization.unopened_count(),
                        .max_unopened_stream_count = limits.max_unopened_stream_count,
                        .certificate_expire_time = std::nullopt,
                        .certificate_fault = ""};
    if (certificates == nullptr) return gauges;
    ServedCertificates::State state = certificates->state();
    gauges.certificate_expire_time = state.expire_time;
    gauges.certificate_fault = std::move(state.fault);
    return gauges;
  }

  ScanLocalizerFactory MakeLocalizerFactory() {
    if (config.stub_matcher) return &CreateStubScanLocalizer;
    return [this](std::shared_ptr<const RadarMap> map, Rig rig,
                  const std::optional<InitialPose>& initial_pose, const LocalizerOptions& options) {
      return CreateCoreScanLocalizer(workspaces, std::move(map), std::move(rig), initial_pose,
                                     options, methods);
    };
  }

  SessionContext MakeSessionContext() {
    return {.pool = localization_pool,
            .totals = registry.totals(),
            .metrics = metrics,
            .create_localizer = MakeLocalizerFactory(),
            .answer_history_count = config.answer_history_count,
            .detached_timeout = std::chrono::milliseconds(config.session_detached_timeout_ms),
            .tickets = tickets.get()};
  }

  /// Binds, and begins to answer calls.
  absl::Status Serve(const std::shared_ptr<grpc::ServerCredentials>& credentials);

  /// Takes new certificates, and says so when those that are shown have expired.
  void WatchCertificates() {
    if (certificates == nullptr) return;
    spdlog::info("certificate shown expires={}", DateText(certificates->state().expire_time));
    certificate_ticker = std::make_unique<Ticker>(kCertificateInterval, [this] {
      const SystemTime now = std::chrono::system_clock::now();
      certificates->Refresh(now);
      health->SetTrustworthy(now < certificates->state().expire_time);
    });
  }

  /// Why not, or what there is to say.
  absl::StatusOr<std::string> Ready() const {
    if (localization.draining()) return absl::UnavailableError("the server is draining");
    if (certificates != nullptr) {
      const ServedCertificates::State state = certificates->state();
      if (state.expire_time <= std::chrono::system_clock::now()) {
        return absl::UnavailableError(
            absl::StrCat("the certificate expired at ", DateText(state.expire_time)));
      }
      if (!state.fault.empty()) return absl::StrCat("ready; certificate not taken: ", state.fault);
    }
    if (absl::Status status = readiness->status(); !status.ok()) return status;
    return "ready";
  }

  /// Not ready any more, and the sessions are told to move; gives how many were told.
  int Drain(std::chrono::milliseconds grace) {
    server_is_set.wait();
    health->SetDraining();
    return localization.Drain(grace);
  }

  /// Not ready while it does not answer its own connections.
  void WatchItself(const ListenAddress& listen) {
    const bool tls = !config.tls_cert.empty();
    liveness = std::make_unique<Liveness>(
        [listen, tls] { return ProbeListener(listen, tls, kSelfProbeTimeout); },
        [this](bool ok) { health->SetAnswering(ok); });
    std::chrono::milliseconds interval(config.self_probe_interval_ms);
    if (const auto watchdog = WatchdogInterval()) {
      const auto often = std::chrono::duration_cast<std::chrono::milliseconds>(*watchdog / 3);
      interval = interval.count() == 0 ? often : std::min(interval, often);
    }
    if (interval.count() == 0) return;
    liveness_ticker = std::make_unique<Ticker>(interval, [this] { liveness->Check(); });
  }

  absl::Status ServeMetrics() {
    if (config.metrics_listen.empty()) return absl::OkStatus();
    const absl::StatusOr<ListenAddress> listen = ParseMetricsAddress(config.metrics_listen);
    if (!listen.ok()) return listen.status();
    auto state = std::make_shared<StateMetrics>(StateMetrics::Sources{
        .registry = registry,
        .store = store,
        .scrub = scrub,
        .localization_pool = localization_pool,
        .storage_pool = storage_pool,
        .draining = [this] { return localization.draining(); },
        .unopened_stream_count = [this] { return localization.unopened_count(); },
        .download_count = [this] { return maps.download_count(); },
        .replica_count = [this] { return replicas.known_count(); },
        .limits = limits,
        .peer_faults = peer_bound_calls.faults(),
        .refused_calls = gate->refused(),
        .certificates = certificates.get(),
        .answering = [this] { return liveness->ok(); },
        .refused_connection_count = [this] { return listener->refused_count(); },
        .objects = kept.objects.get(),
        .cache = kept.cache.get(),
        .version = DCLOC_VERSION});
    readiness = std::make_unique<Readiness>([this] {
      return ProbeListener(*ParseListenAddress(address), !config.tls_cert.empty(), kReadyTimeout);
    });
    readiness->Check();
    readiness_ticker = std::make_unique<Ticker>(kReadyInterval, [this] { readiness->Check(); });
    auto pages = server::ServeMetrics(*listen, {metrics.registry(), std::move(state)},
                                      [this] { return Ready(); });
    if (!pages.ok()) return pages.status();
    metrics_pages = *std::move(pages);
    spdlog::info("metrics served address={}", metrics_pages->address());
    return absl::OkStatus();
  }

  ServerConfig config;
  const RegistrationMethods methods;
  const std::chrono::milliseconds drain_grace;
  const std::shared_ptr<CallGate> gate;
  std::shared_ptr<ServedCertificates> certificates;  ///< null without TLS
  std::unique_ptr<SessionTickets> tickets;           ///< null without fleet keys
  Limits limits;
  UsageCounts usages{limits};
  Storage kept;
  AccessControl access;
  MapStore& store;
  WorkspacePool workspaces;
  SessionRegistry registry;
  SessionMetrics metrics;
  RecordingRequests recordings;
  OperationLog operations;
  OpenCalls open_calls;
  PeerBoundCalls peer_bound_calls;
  WorkerPool storage_pool{kStorageThreads, kMapThreads};
  Replicas replicas;
  const StorageHost storage{store,  storage_pool, open_calls, peer_bound_calls,
                            access, operations,   limits};
  WorkerPool localization_pool;
  LocalizationService localization;
  MapService maps;
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
  Ticker ticker;
  MapScrub scrub;
  Ticker sweeper;
  std::string address;
};

absl::Status Server::Parts::Serve(const std::shared_ptr<grpc::ServerCredentials>& credentials) {
  grpc::EnableDefaultHealthCheckService(true);
  grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  grpc::ServerBuilder builder;
  SetUpTransport(config, builder);
  absl::StatusOr<ListenAddress> bound = ParseListenAddress(config.listen);
  if (!bound.ok()) return bound.status();
  absl::StatusOr<std::unique_ptr<Listener>> bound_listener =
      Listener::Bind(*bound, ConnectionBounds(config));
  if (!bound_listener.ok()) return bound_listener.status();
  bound->port = (*bound_listener)->port();
  auto acceptor = builder.experimental().AddExternalConnectionAcceptor(
      grpc::ServerBuilder::experimental_type::ExternalConnectionType::FROM_FD, credentials);
  builder.RegisterService(&localization);
  builder.RegisterService(&maps);
  builder.RegisterService(&admin);
  server = builder.BuildAndStart();
  if (server == nullptr) return absl::InternalError("gRPC cannot start a server");
  health = std::make_unique<Health>(*server);
  server_is_set.count_down();
  address = bound->ToString();
  if (!config.replica_address.empty()) {
    absl::StatusOr<std::string> known_as = ReplicaAddressOf(config, bound->port);
    if (!known_as.ok()) return known_as.status();
    replicas.Join(*std::move(known_as));
  }
  listener = *std::move(bound_listener);
  listener->Start(std::move(acceptor));
  WatchItself(*bound);
  WatchCertificates();
  return ServeMetrics();
}

absl::StatusOr<std::unique_ptr<Server>> Server::Start(const ServerConfig& config,
                                                      RegistrationMethods methods) {
  if (absl::Status status = Validate(config); !status.ok()) return status;
  auto gate = std::make_shared<CallGate>(config.max_call_rate_hz_per_connection);
  absl::StatusOr<Credentials> credentials = MakeCredentials(config, gate);
  if (!credentials.ok()) return credentials.status();
  absl::StatusOr<std::unique_ptr<SessionTickets>> tickets = TicketsOf(config);
  if (!tickets.ok()) return tickets.status();
  absl::StatusOr<Storage> storage = OpenStorage(config, MapStoreOptionsOf(config));
  if (!storage.ok()) return WithPrefix("data: ", storage.status());
  auto parts =
      std::make_unique<Parts>(config, std::move(methods), *std::move(storage), std::move(gate),
                              credentials->certificates, *std::move(tickets));
  if (absl::Status status = SayWhoIsLetIn(parts->access, config); !status.ok()) return status;
  parts->gate->SetProofNeeded(parts->access.needs_proof());
  if (absl::Status status = parts->Serve(credentials->credentials); !status.ok()) return status;
  return std::unique_ptr<Server>(new Server(std::move(parts)));
}

Server::Server(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

Server::~Server() { Shutdown(std::chrono::milliseconds(0)); }

const std::string& Server::address() const { return parts_->address; }

std::string Server::metrics_address() const {
  return parts_->metrics_pages == nullptr ? "" : parts_->metrics_pages->address();
}

absl::Status Server::Reload(const ServerConfig& config) {
  if (absl::Status status = Validate(config); !status.ok()) return status;
  if (config.log_level != parts_->config.log_level) {
    spdlog::set_level(spdlog::level::from_str(config.log_level));
  }
  for (const ConfigField* field : ChangedFields(parts_->config, config)) {
    if (field->reloadable) {
      TakeField(*field, config, &parts_->config);
      spdlog::info("setting taken key={}", field->key);
    } else {
      spdlog::warn("setting not taken, it needs a restart key={}", field->key);
    }
  }
  parts_->limits.Set(parts_->config);
  return absl::OkStatus();
}

void Server::Shutdown(std::chrono::milliseconds deadline) {
  const auto begin = std::chrono::steady_clock::now();
  const auto end = begin + deadline;
  parts_->liveness_ticker.reset();
  // What sessions of this server do not end.
  parts_->admin.EndWaiting();
  // Half of the time at most is the clients', to go by themselves.
  const std::chrono::milliseconds grace = std::min(parts_->drain_grace, deadline / 2);
  if (parts_->Drain(grace) > 0) parts_->open_calls.WaitUntilNone(begin + grace);
  if (auto* health = parts_->server->GetHealthCheckService()) health->Shutdown();
  parts_->localization.EndAll(
      grpc::Status(grpc::StatusCode::UNAVAILABLE, "the server is shutting down"));
  parts_->registry.RemoveDetached("the server is shutting down");
  parts_->open_calls.WaitUntilNone(end);
  parts_->listener->Stop();
  // What is left are calls beyond the deadline, last bytes on their way, and idle connections.
  parts_->server->Shutdown(std::chrono::system_clock::now() + kLastBytesGrace);
  // Cut-off calls end at once, but their last events may still be under way.
  parts_->open_calls.WaitUntilNone();
}

}  // namespace dcloc::server
