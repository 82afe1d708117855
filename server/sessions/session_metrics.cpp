#include "server/sessions/session_metrics.h"

#include <utility>

namespace dcloc::server {
namespace {

using prometheus::Histogram;
using prometheus::Registry;

/// From a stub's microseconds to where a vehicle has long given up.
const Histogram::BucketBoundaries& DurationBuckets_s() {
  static const Histogram::BucketBoundaries buckets = {1e-5, 2.5e-5, 5e-5, 1e-4, 2.5e-4, 5e-4,
                                                      1e-3, 2.5e-3, 5e-3, 1e-2, 2e-2,   5e-2,
                                                      1e-1, 2.5e-1, 5e-1, 1.0,  2.5,    10.0};
  return buckets;
}

/// Quantiles of chi-square with three degrees of freedom, the share of the bound in the comment: of
/// an honest covariance the shares of the counts are these.
const Histogram::BucketBoundaries& ChiSquareBuckets() {
  static const Histogram::BucketBoundaries buckets = {0.352,   // 5 %
                                                      1.213,   // 25 %
                                                      2.366,   // 50 %
                                                      4.108,   // 75 %
                                                      6.251,   // 90 %
                                                      7.815,   // 95 %
                                                      11.345,  // 99 %
                                                      16.266,  // 99.9 %
                                                      30.0,   100.0};
  return buckets;
}

Histogram& AddHistogram(Registry& registry, const char* name, const char* help,
                        const Histogram::BucketBoundaries& buckets) {
  return prometheus::BuildHistogram().Name(name).Help(help).Register(registry).Add({}, buckets);
}

prometheus::Family<prometheus::Counter>& AddCounters(Registry& registry, const char* name,
                                                     const char* help) {
  return prometheus::BuildCounter().Name(name).Help(help).Register(registry);
}

prometheus::Counter& AddCounter(Registry& registry, const char* name, const char* help) {
  return AddCounters(registry, name, help).Add({});
}

double Seconds(std::chrono::nanoseconds duration) {
  return std::chrono::duration<double>(duration).count();
}

/// Of the codes that a client can cause, so that there are few and always the same.
const char* ReasonOf(absl::StatusCode code) {
  switch (code) {
    case absl::StatusCode::kInvalidArgument:
      return "invalid";
    case absl::StatusCode::kOutOfRange:
      return "late";
    case absl::StatusCode::kResourceExhausted:
      return "limit";
    default:
      return "other";
  }
}

const char* NameOf(grpc::StatusCode code) {
  switch (code) {
    case grpc::StatusCode::OK:
      return "ok";
    case grpc::StatusCode::INVALID_ARGUMENT:
      return "invalid_argument";
    case grpc::StatusCode::NOT_FOUND:
      return "not_found";
    case grpc::StatusCode::PERMISSION_DENIED:
      return "permission_denied";
    case grpc::StatusCode::UNAUTHENTICATED:
      return "unauthenticated";
    case grpc::StatusCode::RESOURCE_EXHAUSTED:
      return "resource_exhausted";
    case grpc::StatusCode::FAILED_PRECONDITION:
      return "failed_precondition";
    case grpc::StatusCode::UNAVAILABLE:
      return "unavailable";
    default:
      return "other";
  }
}

constexpr std::array kStageLabels = {"queue",        "conversion", "compensation", "submap",
                                     "registration", "posegraph",  "encoding"};
constexpr std::array kStateLabels = {"initializing", "tracking", "dead_reckoning", "lost"};
constexpr char kRegistrationHelp[] = "Registrations, by whether they passed the innovation test";
constexpr char kMapHelp[] = "Maps that new sessions asked for, by whether they were in memory";
constexpr std::array kReasons = {"invalid", "late", "limit", "other"};
/// Those of FixUse, then the refusals.
constexpr std::array kUses = {"fused",       "agrees",  "guides_search", "contradicted",
                              "out_of_time", "invalid", "over_limit"};

std::size_t IndexOf(const absl::StatusOr<FixUse>& use) {
  if (use.ok()) return static_cast<std::size_t>(*use);
  return kUses.size() - (absl::IsResourceExhausted(use.status()) ? 1 : 2);
}

}  // namespace

SessionMetrics::ScanMetrics::ScanMetrics(Registry& registry)
    : duration(AddHistogram(registry, "dcloc_scan_seconds",
                            "From a scan's arrival until its answer was handed to the transport",
                            DurationBuckets_s())),
      protection_level(AddHistogram(registry, "dcloc_protection_level_meters",
                                    "Protection levels of answers that have one",
                                    {0.1, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0, 30.0})),
      wrong_beta(AddCounter(registry, "dcloc_wrong_beta_answers_total",
                            "Answers to scans of radars whose beta_s the residuals contradict")),
      repeated(AddCounter(registry, "dcloc_scans_repeated_total",
                          "Scans that were sent again and answered from memory")),
      dropped(AddCounter(registry, "dcloc_scans_dropped_total",
                         "Scans dropped for newer ones, where the client asked for it")),
      rejected(AddCounters(registry, "dcloc_scans_rejected_total",
                           "Scans that were refused, by reason")) {
  auto& by_stage = prometheus::BuildHistogram()
                       .Name("dcloc_scan_stage_seconds")
                       .Help("Duration of each stage of a scan; only stages that ran")
                       .Register(registry);
  for (std::size_t i = 0; i < kStageCount; ++i) {
    stages[i] = &by_stage.Add({{"stage", kStageLabels[i]}}, DurationBuckets_s());
  }
  auto& by_state = AddCounters(registry, "dcloc_answers_total", "Scans localized, by state");
  for (std::size_t i = 0; i < kStateCount; ++i) {
    answers[i] = &by_state.Add({{"state", kStateLabels[i]}});
  }
  // There from the start: a rate needs the zero before the first one.
  for (const char* reason : kReasons) rejected.Add({{"reason", reason}});
}

SessionMetrics::RegistrationMetrics::RegistrationMetrics(Registry& registry)
    : normalized_innovation_squared(AddHistogram(
          registry, "dcloc_loop_edge_distance",
          "Squared Mahalanobis distance between a registration and its prediction; 3 in the mean "
          "when the covariances are right",
          ChiSquareBuckets())),
      residual_scale(AddHistogram(registry, "dcloc_residual_scale",
                                  "Root mean square of a registration's whitened residuals; 1 is "
                                  "as modelled",
                                  {0.25, 0.5, 0.75, 0.9, 1.0, 1.1, 1.25, 1.5, 2.0, 3.0, 5.0})),
      overlap(AddHistogram(registry, "dcloc_overlap",
                           "Share of a sub-map's points that are inliers of its registration",
                           {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0})),
      accepted(AddCounters(registry, "dcloc_loop_edges_total", kRegistrationHelp)
                   .Add({{"valid", "true"}})),
      refused(AddCounters(registry, "dcloc_loop_edges_total", kRegistrationHelp)
                  .Add({{"valid", "false"}})) {}

SessionMetrics::HealthMetrics::HealthMetrics(Registry& registry)
    : pose_resets(AddCounter(registry, "dcloc_pose_resets_total",
                             "Jumps of answered poses: a place found anew, a large correction")) {
  auto& by_reason = AddCounters(registry, "dcloc_sources_set_aside_total",
                                "Sources set aside, by their kind and the reason; one that flaps "
                                "counts once in ten seconds");
  auto& by_kind = AddCounters(registry, "dcloc_answers_with_source_set_aside_total",
                              "Scans localized while a source of that kind was set aside");
  for (std::size_t kind = 0; kind < kKindCount; ++kind) {
    answers_set_aside[kind] = &by_kind.Add({{"source", kSourceKindNames[kind]}});
    for (std::size_t fault = 0; fault < kFaultCount; ++fault) {
      set_aside[kind][fault] = &by_reason.Add(
          {{"source", kSourceKindNames[kind]}, {"reason", kSourceFaultNames[fault]}});
    }
  }
  auto& by_use =
      AddCounters(registry, "dcloc_position_fixes_total", "Position fixes, by what became of them");
  static_assert(kUses.size() == kUseCount);
  for (std::size_t use = 0; use < kUseCount; ++use) fixes[use] = &by_use.Add({{"use", kUses[use]}});
}

SessionMetrics::OpenMetrics::OpenMetrics(Registry& registry)
    : opens(AddCounters(registry, "dcloc_session_opens_total",
                        "Localize calls, by the result of their open message")),
      map_acquire(AddHistogram(registry, "dcloc_map_acquire_seconds",
                               "Getting a new session's map; microseconds where it is in memory",
                               DurationBuckets_s())),
      map_hits(
          AddCounters(registry, "dcloc_map_acquires_total", kMapHelp).Add({{"in_memory", "true"}})),
      map_misses(AddCounters(registry, "dcloc_map_acquires_total", kMapHelp)
                     .Add({{"in_memory", "false"}})) {
  opens.Add({{"code", "ok"}, {"resumed", "false"}});
  opens.Add({{"code", "ok"}, {"resumed", "true"}});
}

SessionMetrics::TicketMetrics::TicketMetrics(Registry& registry)
    : tickets(AddCounter(registry, "dcloc_tickets_total", "Session tickets handed out")),
      bytes(AddCounter(registry, "dcloc_ticket_bytes_total", "Bytes of these tickets")),
      catch_up_scans(AddCounter(registry, "dcloc_catch_up_scans_total",
                                "Scans localized without an answer, to go on from a ticket")) {
  auto& by_use = AddCounters(registry, "dcloc_ticket_uses_total",
                             "Tickets that opening clients presented, by what became of them");
  for (std::size_t use = 1; use < uses.size(); ++use) {
    uses[use] = &by_use.Add({{"use", kTicketUseNames[use]}});
  }
}

SessionMetrics::SessionMetrics()
    : registry_(std::make_shared<Registry>()),
      scans_(*registry_),
      registrations_(*registry_),
      health_(*registry_),
      opens_(*registry_),
      tickets_(*registry_) {}

void SessionMetrics::ObserveLocalized(const LocalizedScan& scan,
                                      std::chrono::nanoseconds encoding) {
  const ScanTimings& timings = scan.timings;
  const std::array durations = {timings.queue,  timings.conversion,   timings.compensation,
                                timings.submap, timings.registration, timings.posegraph,
                                encoding};
  static_assert(durations.size() == kStageCount);
  for (std::size_t i = 0; i < kStageCount; ++i) {
    if (durations[i].count() > 0) scans_.stages[i]->Observe(Seconds(durations[i]));
  }
  scans_.duration.Observe(Seconds(timings.total + encoding));
  scans_.answers[static_cast<std::size_t>(scan.localization.state)]->Increment();
  const LocalizationQuality& quality = scan.localization.quality;
  if (timings.registration.count() > 0 && quality.inlier_count > 0) registrations_.Observe(quality);
  if (quality.beta.is_wrong) scans_.wrong_beta.Increment();
  if (const auto& level_m = scan.localization.protection_level_m) {
    scans_.protection_level.Observe(*level_m);
  }
}

void SessionMetrics::RegistrationMetrics::Observe(const LocalizationQuality& quality) {
  normalized_innovation_squared.Observe(quality.normalized_innovation_squared);
  residual_scale.Observe(quality.residual_scale);
  overlap.Observe(quality.overlap);
  (quality.is_accepted ? accepted : refused).Increment();
}

void SessionMetrics::ObserveRejection(absl::StatusCode code) {
  scans_.rejected.Add({{"reason", ReasonOf(code)}}).Increment();
}

void SessionMetrics::ObserveHealth(const HealthChanges& changes) {
  for (const SourceChange& change : changes.sources) {
    if (change.health.is_used) continue;
    health_
        .set_aside[static_cast<std::size_t>(change.kind)]
                  [static_cast<std::size_t>(change.health.fault)]
        ->Increment();
  }
  for (std::size_t kind = 0; kind < kKindCount; ++kind) {
    if (changes.set_aside[kind]) health_.answers_set_aside[kind]->Increment();
  }
  if (changes.new_reset_count > 0) health_.pose_resets.Increment(changes.new_reset_count);
}

void SessionMetrics::ObserveFix(const absl::StatusOr<FixUse>& use) {
  health_.fixes[IndexOf(use)]->Increment();
}

void SessionMetrics::ObserveTicket(std::size_t size) {
  tickets_.tickets.Increment();
  tickets_.bytes.Increment(static_cast<double>(size));
}

void SessionMetrics::ObserveTicketUse(TicketUse use) {
  if (use != TicketUse::kNone) tickets_.uses[static_cast<std::size_t>(use)]->Increment();
}

void SessionMetrics::ObserveDropped() { scans_.dropped.Increment(); }

void SessionMetrics::ObserveRepeated() { scans_.repeated.Increment(); }

void SessionMetrics::ObserveOpen(grpc::StatusCode code, bool resumed) {
  opens_.opens.Add({{"code", NameOf(code)}, {"resumed", resumed ? "true" : "false"}}).Increment();
}

void SessionMetrics::ObserveMapAcquired(std::chrono::nanoseconds duration, bool was_in_memory) {
  (was_in_memory ? opens_.map_hits : opens_.map_misses).Increment();
  opens_.map_acquire.Observe(Seconds(duration));
}

}  // namespace dcloc::server
