#include "server/app/server_parts.h"

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/server_builder.h>
#include <malloc.h>

#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/localizer/workspace.h"
#include "server/app/part_options.h"
#include "server/app/state_metrics.h"
#include "server/app/transport.h"
#include "server/base/memory_reserve.h"
#include "server/net/self_probe.h"
#include "server/net/service_manager.h"
#include "server/sessions/move_sessions.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

/// What waits for a disk needs few threads; what reads whole maps has its own, which take the
/// processor after those that localize.
constexpr int kStorageThreads = 2;
constexpr int kMapThreads = 2;

constexpr std::chrono::seconds kSelfProbeTimeout(3);
constexpr std::chrono::milliseconds kReadyTimeout(800);
constexpr std::chrono::milliseconds kReadyInterval(500);  ///< of asking whether it is ready
constexpr std::chrono::seconds kCertificateInterval(1);   ///< of looking at the files
constexpr std::chrono::milliseconds kTickInterval(100);   ///< of timeouts of sessions
constexpr std::chrono::seconds kCanaryInterval(1);        ///< of looking at vehicles in canaries
constexpr int kLooksPerJudgement = 10;
constexpr int kSweepsPerOrphanLook = 10;
constexpr std::chrono::minutes kSweepInterval(1);  ///< of unfinished uploads and the quarantine

void LogSwept(const char* what, const absl::StatusOr<int>& count, const char* done = "removed") {
  if (!count.ok()) {
    spdlog::warn("{} not {} reason={}", what, done, Quoted(count.status().message()));
  } else if (*count > 0) {
    spdlog::info("{} {} count={}", what, done, *count);
  }
}

}  // namespace

Server::Parts::Parts(const ServerConfig& server_config, RegistrationMethods registration,
                     Storage opened, std::shared_ptr<CallGate> call_gate,
                     std::shared_ptr<ServedCertificates> served_certificates,
                     std::unique_ptr<SessionTickets> fleet_tickets)
    : config(server_config),
      methods(std::move(registration)),
      drain_notice(config.drain_notice_ms),
      drain_grace(config.drain_grace_ms),
      gate(std::move(call_gate)),
      certificates(std::move(served_certificates)),
      tickets(std::move(fleet_tickets)),
      limits(config),
      opened_storage(std::move(opened)),
      access(*opened_storage.identities, config.require_identity),
      store(*opened_storage.maps),
      passes(*opened_storage.passes, store.incoming().folder(), [this] { return PassBoundsNow(); }),
      registry(limits, SessionTimeoutsOf(config)),
      awaited_requests(
          [this] {
            return AwaitedRequests::Bounds{
                .count = UnopenedBounds(),
                .time = std::chrono::milliseconds(limits.open_timeout_ms)};
          },
          peer_bound_calls.faults()),
      bounded_calls(
          [this] {
            return BoundedCalls::Times{
                .reflection = std::chrono::milliseconds(limits.open_timeout_ms),
                .reading = std::chrono::milliseconds(limits.peer_timeout_ms)};
          },
          peer_bound_calls.faults()),
      health_service(awaited_requests, [this] { return UnopenedBounds(); }),
      storage_pool(kStorageThreads, kMapThreads),
      replicas({.directory = opened_storage.replicas.get(), .access = access, .pool = storage_pool},
               ReplicaTlsOf(config),
               {.answer = std::chrono::milliseconds(config.replica_timeout_ms)}),
      localization_pool(WorkerCount(config), WorkerCount(config)),
      localization({.storage = rpc_context,
                    .registry = registry,
                    .sessions = {.store = store,
                                 .recordings = recordings,
                                 .passes = passes,
                                 .context = MakeSessionContext()},
                    .usages = usages,
                    .max_pending_scan_count = config.max_pending_scan_count}),
      maps(
          rpc_context, *opened_storage.passes,
          [this](const std::string& tenant, const std::string& map_name) {
            return MoveSessions(registry, store, tenant, map_name);
          },
          MakeSessionDrainer()),
      pass_service(rpc_context, *opened_storage.passes),
      admin({.version = DCLOC_VERSION,
             .start_time = std::chrono::system_clock::now(),
             .worker_count = localization_pool.thread_count(),
             .stub_localizer = config.stub_localizer},
            registry, recordings, *opened_storage.identities, rpc_context, replicas,
            {.drain =
                 [this] {
                   return BeginDrain(std::chrono::steady_clock::now() + drain_notice, drain_grace);
                 },
             .draining = [this] { return localization.draining(); }},
            [this] { return Gauges(); }),
      ticker(kTickInterval, [this] { EndOverdue(); }),
      scrub(store.catalogue(), store.files(), {.max_bytes_per_s = 1e6 * config.scrub_mb_per_s}),
      sweeper(kSweepInterval, [this] { Sweep(); }) {
  if (!config.keep_worse_canaries) {
    canary_ticker = std::make_unique<Ticker>(kCanaryInterval, [this] { WatchCanaries(); });
  }
  // Passes are kept until a time; the server may have been stopped since.
  storage_pool.Post([this] { RemoveExpiredPasses(); }, Lane::kLengthy);
  // The pools' threads are older than what they will use of this; their locks hand it to them.
  storage_pool.Post([] {});
  localization_pool.Post([] {});
}

absl::Status Server::Parts::Serve(const std::shared_ptr<grpc::ServerCredentials>& credentials) {
  grpc::EnableDefaultHealthCheckService(false);  // ours bounds its callers
  grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  grpc::ServerBuilder builder;
  SetUpTransport(config, bounded_calls, builder);
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
  builder.RegisterService(&pass_service);
  builder.RegisterService(&admin);
  builder.RegisterService(&health_service);
  server = builder.BuildAndStart();
  if (server == nullptr) return absl::InternalError("gRPC cannot start a server");
  health = std::make_unique<Health>(health_service);
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

int Server::Parts::BeginDrain(std::chrono::steady_clock::time_point notice_end,
                              std::chrono::milliseconds grace) {
  server_is_set.wait();
  health->SetDraining();
  const int session_count = localization.GiveNotice(notice_end, grace);
  localization.EndOverdue(std::chrono::steady_clock::now());  // where there is no notice
  return session_count;
}

absl::StatusOr<std::string> Server::Parts::Ready() const {
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

ServerGauges Server::Parts::Gauges() const {
  ServerGauges gauges{.unopened_stream_count = localization.unopened_count(),
                      .awaited_request_count = awaited_requests.count(),
                      .max_unopened_stream_count = limits.max_unopened_stream_count,
                      .certificate_expire_time = std::nullopt,
                      .certificate_fault = ""};
  if (certificates == nullptr) return gauges;
  ServedCertificates::State state = certificates->state();
  gauges.certificate_expire_time = state.expire_time;
  gauges.certificate_fault = std::move(state.fault);
  return gauges;
}

WaitingBounds Server::Parts::UnopenedBounds() const {
  return {.total = limits.max_unopened_stream_count,
          .group = limits.max_unopened_stream_count_per_peer};
}

ScanLocalizerFactory Server::Parts::MakeLocalizerFactory() {
  if (config.stub_localizer) return &CreateStubScanLocalizer;
  return [this](std::shared_ptr<const RadarMap> map, Rig rig,
                const std::optional<InitialPose>& initial_pose, const LocalizerOptions& options) {
    return CreateCoreScanLocalizer(workspaces, std::move(map), std::move(rig), initial_pose,
                                   options, methods);
  };
}

SessionContext Server::Parts::MakeSessionContext() {
  return {.pool = localization_pool,
          .totals = registry.totals(),
          .metrics = metrics,
          .create_localizer = MakeLocalizerFactory(),
          .answer_history_count = config.answer_history_count,
          .detached_timeout = std::chrono::milliseconds(config.session_detached_timeout_ms),
          .tickets = tickets.get()};
}

SessionDrainer Server::Parts::MakeSessionDrainer() {
  return {.move_or_end =
              [this](const std::string& tenant, const std::string& map_name, std::int64_t version) {
                MoveSessions(registry, store, tenant, map_name, version);
                EndSessions(registry, tenant, map_name, version, EndOf::kNotMoved);
              },
          .end_all =
              [this](const std::string& tenant, const std::string& map_name, std::int64_t version) {
                EndSessions(registry, tenant, map_name, version, EndOf::kAll);
              }};
}

void Server::Parts::WatchItself(const ListenAddress& listen) {
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

void Server::Parts::WatchCertificates() {
  if (certificates == nullptr) return;
  spdlog::info("certificate shown expires={}", DateText(certificates->state().expire_time));
  certificate_ticker = std::make_unique<Ticker>(kCertificateInterval, [this] {
    const SystemTime now = std::chrono::system_clock::now();
    certificates->Refresh(now);
    health->SetTrustworthy(now < certificates->state().expire_time);
  });
}

absl::Status Server::Parts::ServeMetrics() {
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
      .awaited_request_count = [this] { return awaited_requests.count(); },
      .health_watcher_count = [this] { return health_service.watcher_count(); },
      .download_count = [this] { return maps.download_count(); },
      .replica_count = [this] { return replicas.known_count(); },
      .limits = limits,
      .peer_faults = peer_bound_calls.faults(),
      .refused_calls = gate->refused(),
      .certificates = certificates.get(),
      .answering = [this] { return liveness->ok(); },
      .refused_connection_count = [this] { return listener->refused_count(); },
      .objects = opened_storage.objects.get(),
      .cache = opened_storage.cache.get(),
      .passes = passes.counts(),
      .withdrawn_canary_count = [this] { return canary_watch.withdrawn_count(); },
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

void Server::Parts::EndOverdue() {
  const auto now = std::chrono::steady_clock::now();
  TellOfMemory();
  registry.Reap(now);
  peer_bound_calls.Check(now);
  awaited_requests.EndOverdue(now);
  bounded_calls.EndOverdue(now);
  if (access.needs_proof()) gate->SetProofNeeded(true);
  if (!localization.EndOverdue(now)) return;
  // Nobody can resume them here any more.
  registry.RemoveDetached("the server is draining");
}

void Server::Parts::TellOfMemory() {
  const bool was_short = std::exchange(memory_is_short, !MemoryReserve::OfProcess().Tend());
  if (memory_is_short == was_short) return;
  if (memory_is_short) {
    spdlog::error("no memory is left, the reserve is given: new calls are refused");
  } else {
    spdlog::info("memory is there again: new calls are taken");
  }
}

PassBounds Server::Parts::PassBoundsNow() const {
  constexpr std::int64_t kMib = std::int64_t{1} << 20;
  return {.quota = {.max_tenant_bytes = kMib * limits.pass_storage_mib,
                    .max_vehicle_bytes_per_day = kMib * limits.pass_vehicle_mib_per_day},
          .retention = std::chrono::days(limits.pass_retention_days)};
}

void Server::Parts::WatchCanaries() {
  canary_watch.Look();
  if (++canary_look_count % kLooksPerJudgement == 0) canary_watch.Judge();
}

void Server::Parts::RemoveExpiredPasses() {
  LogSwept("passes", opened_storage.passes->RemoveExpired(std::chrono::system_clock::now()));
}

void Server::Parts::Sweep() {
  const auto now = std::chrono::steady_clock::now();
  const auto since_last = now - std::exchange(last_sweep, now);
  LogSwept("stale uploads", store.RemoveStaleUploads(since_last));
  LogSwept("map files of no version", store.SetLooseFilesAside(), "set aside");
  LogSwept("files in quarantine", store.RemoveExpiredQuarantine(since_last));
  RemoveExpiredPasses();
  malloc_trim(0);  // what is free of each arena goes back to the system
  if (++sweep_count % kSweepsPerOrphanLook != 0) return;
  LogSwept("files of no pass", opened_storage.passes->RemoveOrphans());
}

}  // namespace dcloc::server
