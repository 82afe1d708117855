#include "server/app/state_metrics.h"

#include <array>
#include <chrono>
#include <tuple>
#include <utility>

#include "server/app/map_file_metrics.h"
#include "server/app/pass_metrics.h"
#include "server/telemetry/metric_family.h"
#include "server/telemetry/process_metrics.h"

namespace dcloc::server {
namespace {

using prometheus::MetricFamily;

void AddScrub(const ScrubState& scrub, std::vector<MetricFamily>& families) {
  families.push_back(GaugeOf("dcloc_map_files_damaged",
                             "Map files that were missing or damaged when they were read last",
                             scrub.damaged_file_count));
  families.push_back(CounterOf("dcloc_map_scrub_bytes_total",
                               "Bytes of map files that were read against their hashes",
                               static_cast<double>(scrub.checked_bytes)));
  if (!scrub.last_pass_end) return;
  const std::chrono::duration<double> last = scrub.last_pass_end->time_since_epoch();
  families.push_back(GaugeOf("dcloc_map_scrub_last_pass_seconds",
                             "When all map files had been read last, in Unix time; the server's "
                             "start before that. Not there when scrub_mb_per_s is 0",
                             last.count()));
}

MetricFamily Sessions(const SessionRegistry& registry) {
  MetricFamily family =
      GaugeOf("dcloc_sessions",
              "Open sessions, by whether a stream is attached and by the state of "
              "the last answer");
  constexpr std::array kStates = {"none", "initializing", "tracking", "dead_reckoning", "lost"};
  const SessionCensus census = registry.Census();
  static_assert(kStates.size() == std::tuple_size_v<decltype(census.attached)>);
  for (std::size_t i = 0; i < kStates.size(); ++i) {
    AddGauge(family, {{"stream", "attached"}, {"state", kStates[i]}}, census.attached[i]);
    AddGauge(family, {{"stream", "detached"}, {"state", kStates[i]}}, census.detached[i]);
  }
  return family;
}

MetricFamily QueueDepths(const WorkerPool& localization, const WorkerPool& storage) {
  MetricFamily family =
      GaugeOf("dcloc_queue_depth", "Tasks that wait for a thread: one for each session at most");
  AddGauge(family, {{"pool", "localization"}}, static_cast<double>(localization.queued_count()));
  AddGauge(family, {{"pool", "search"}},
           static_cast<double>(localization.queued_count(Lane::kLengthy)));
  AddGauge(family, {{"pool", "storage"}}, static_cast<double>(storage.queued_count()));
  AddGauge(family, {{"pool", "maps"}}, static_cast<double>(storage.queued_count(Lane::kLengthy)));
  return family;
}

double Seconds(SystemTime time) {
  return std::chrono::duration<double>(time.time_since_epoch()).count();
}

void AddCertificate(const ServedCertificates& certificates, std::vector<MetricFamily>& families) {
  const ServedCertificates::State state = certificates.state();
  families.push_back(GaugeOf("dcloc_tls_certificate_ok",
                             "0 when the files have another certificate, which is not good",
                             state.fault.empty() ? 1.0 : 0.0));
  families.push_back(GaugeOf("dcloc_tls_certificate_expire_time_seconds",
                             "When the certificate that is shown expires, Unix time",
                             Seconds(state.expire_time)));
}

MetricFamily BuildInfo(const std::string& version) {
  MetricFamily build = GaugeOf("dcloc_build_info", "1; the label says which program this is");
  AddGauge(build, {{"version", version}}, 1.0);
  return build;
}

}  // namespace

std::vector<MetricFamily> StateMetrics::Collect() const {
  std::vector<MetricFamily> families = ProcessMetrics();
  AddWork(families);
  AddPeers(families);
  AddMapFiles(families);
  families.push_back(BuildInfo(sources_.version));
  return families;
}

// Sessions, the threads that serve them, and the servers beside this one.
void StateMetrics::AddWork(std::vector<MetricFamily>& families) const {
  families.push_back(Sessions(sources_.registry));
  families.push_back(GaugeOf("dcloc_sessions_max", "The most sessions that the server takes",
                             sources_.registry.max_session_count()));
  families.push_back(QueueDepths(sources_.localization_pool, sources_.storage_pool));
  families.push_back(
      GaugeOf("dcloc_workers", "Threads that localize", sources_.localization_pool.thread_count()));
  families.push_back(
      GaugeOf("dcloc_maps_loaded", "Map versions in memory", sources_.store.loaded_map_count()));
  families.push_back(GaugeOf("dcloc_draining", "1 when the server takes no more sessions",
                             sources_.draining() ? 1.0 : 0.0));
  families.push_back(GaugeOf(
      "dcloc_replicas", "Servers that share its catalogue, as it knows them, itself among them",
      sources_.replica_count()));
  families.push_back(GaugeOf("dcloc_self_probe_ok",
                             "0 when the server does not answer its own connections",
                             sources_.answering() ? 1.0 : 0.0));
}

// What peers do and do not do.
void StateMetrics::AddPeers(std::vector<MetricFamily>& families) const {
  families.push_back(GaugeOf("dcloc_unopened_streams", "Localize streams whose open has not come",
                             sources_.unopened_stream_count()));
  families.push_back(GaugeOf("dcloc_unopened_streams_max", "The most of them",
                             sources_.limits.max_unopened_stream_count));
  families.push_back(GaugeOf("dcloc_awaited_requests",
                             "Calls but Localize whose request has not come; as many at most",
                             sources_.awaited_request_count()));
  families.push_back(GaugeOf("dcloc_health_watchers", "Callers that watch the server's health",
                             sources_.health_watcher_count()));
  families.push_back(GaugeOf("dcloc_downloads", "Downloads of maps that are under way",
                             sources_.download_count()));
  if (sources_.certificates != nullptr) AddCertificate(*sources_.certificates, families);
  families.push_back(CountersBy("reason", "dcloc_calls_ended_total",
                                "Calls that were ended because of what their peer did not do",
                                {{"not_sending", sources_.peer_faults.not_sending},
                                 {"not_reading", sources_.peer_faults.not_reading},
                                 {"too_many_unopened", sources_.peer_faults.too_many_waiting}}));
  families.push_back(CountersBy("reason", "dcloc_calls_refused_total",
                                "Calls that were refused when their headers came",
                                {{"no_identity", sources_.refused_calls.without_proof},
                                 {"too_fast", sources_.refused_calls.too_fast},
                                 {"out_of_memory", sources_.refused_calls.out_of_memory}}));
  families.push_back(CounterOf("dcloc_connections_refused_total",
                               "Connections closed at once, as too few file descriptors were left",
                               static_cast<double>(sources_.refused_connection_count())));
}

void StateMetrics::AddMapFiles(std::vector<MetricFamily>& families) const {
  AddScrub(sources_.scrub.state(), families);
  if (const std::optional<int> count = sources_.store.quarantined_count()) {
    families.push_back(
        GaugeOf("dcloc_map_files_quarantined",
                "Map files that belong to no version and are set aside, as they were "
                "counted in the last minutes",
                *count));
  }
  AddMapFileMetrics(sources_.objects, sources_.cache, families);
  AddPassMetrics(sources_.passes, families);
  families.push_back(CounterOf("dcloc_canaries_withdrawn_total",
                               "Canaries of maps whose vehicles were TRACKING less than others",
                               static_cast<double>(sources_.withdrawn_canary_count())));
}

}  // namespace dcloc::server
