#pragma once

#include <grpcpp/support/status.h>
#include <prometheus/counter.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>

#include <array>
#include <chrono>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "server/convert/answer.h"
#include "server/convert/session.h"
#include "server/sessions/health_watch.h"

namespace dcloc::server {

/// Prometheus counters and histograms of sessions and scans, updated at each event; gauges are in
/// `app/state_metrics`. Thread-safe. An observation takes a fraction of a microsecond. No label
/// depends on what a client sends.
class SessionMetrics {
 public:
  SessionMetrics();
  SessionMetrics(const SessionMetrics&) = delete;
  SessionMetrics& operator=(const SessionMetrics&) = delete;

  /// A scan was localized. `encoding` is what making the answer's message took.
  void ObserveLocalized(const LocalizedScan& scan, std::chrono::nanoseconds encoding);
  /// A scan was refused, or dropped for newer ones.
  void ObserveRejection(absl::StatusCode code);
  void ObserveDropped();
  void ObserveRepeated();
  /// Of one scan: sources that were set aside, and resets of the pose.
  void ObserveHealth(const HealthChanges& changes);
  void ObserveFix(const absl::StatusOr<FixUse>& use);
  /// A Localize call has opened or resumed a session, or not.
  void ObserveOpen(grpc::StatusCode code, bool resumed);
  /// A ticket of that size was handed out; one was presented; a scan was localized to catch up.
  void ObserveTicket(std::size_t size);
  void ObserveTicketUse(TicketUse use);
  void ObserveCatchUp() { tickets_.catch_up_scans.Increment(); }
  /// The time to get a session's map: microseconds if it was in memory.
  void ObserveMapAcquired(std::chrono::nanoseconds duration, bool was_in_memory);

  const std::shared_ptr<prometheus::Registry>& registry() const { return registry_; }

 private:
  using Counter = prometheus::Counter;
  using Histogram = prometheus::Histogram;
  template <std::size_t kCount>
  using Counters = std::array<Counter*, kCount>;

  static constexpr std::size_t kStageCount = 7;
  static constexpr std::size_t kStateCount = 4;
  static constexpr std::size_t kKindCount = kSourceKindNames.size();
  static constexpr std::size_t kFaultCount = kSourceFaultNames.size();
  static constexpr std::size_t kUseCount = kFixUseNames.size() + 2;

  // Each group registers its own metrics.
  struct ScanMetrics {
    explicit ScanMetrics(prometheus::Registry& registry);
    Histogram& duration;
    Histogram& protection_level;
    std::array<Histogram*, kStageCount> stages{};
    Counters<kStateCount> answers{};
    Counter& wrong_beta;
    Counter& repeated;
    Counter& dropped;
    prometheus::Family<Counter>& rejected;
  };
  struct RegistrationMetrics {
    explicit RegistrationMetrics(prometheus::Registry& registry);
    void Observe(const LocalizationQuality& quality);
    Histogram& normalized_innovation_squared;
    Histogram& residual_scale;
    Histogram& overlap;
    Counter& accepted;
    Counter& refused;
  };
  struct HealthMetrics {
    explicit HealthMetrics(prometheus::Registry& registry);
    std::array<Counters<kFaultCount>, kKindCount> set_aside{};
    Counters<kKindCount> answers_set_aside{};
    Counter& pose_resets;
    Counters<kUseCount> fixes{};
  };
  struct OpenMetrics {
    explicit OpenMetrics(prometheus::Registry& registry);
    prometheus::Family<Counter>& opens;
    Histogram& map_acquire;
    Counter& map_hits;
    Counter& map_misses;
  };
  struct TicketMetrics {
    explicit TicketMetrics(prometheus::Registry& registry);
    Counter& tickets;
    Counter& bytes;
    Counter& catch_up_scans;
    Counters<kTicketUseNames.size()> uses{};
  };

  const std::shared_ptr<prometheus::Registry> registry_;
  ScanMetrics scans_;
  RegistrationMetrics registrations_;
  HealthMetrics health_;
  OpenMetrics opens_;
  TicketMetrics tickets_;
};

}  // namespace dcloc::server
