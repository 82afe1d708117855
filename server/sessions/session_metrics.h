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
  void ObserveCatchUp() { catch_up_scans_.Increment(); }
  /// The time to get a session's map: microseconds if it was in memory.
  void ObserveMapAcquired(std::chrono::nanoseconds duration, bool was_in_memory);

  const std::shared_ptr<prometheus::Registry>& registry() const { return registry_; }

 private:
  static constexpr std::size_t kStageCount = 7;
  static constexpr std::size_t kStateCount = 4;
  static constexpr std::size_t kKindCount = kSourceKindNames.size();
  static constexpr std::size_t kFaultCount = kSourceFaultNames.size();
  static constexpr std::size_t kUseCount = kFixUseNames.size() + 2;

  void AddHealthCounters();
  void AddTicketCounters();
  void ObserveEdge(const LocalizationQuality& quality);

  std::shared_ptr<prometheus::Registry> registry_;
  std::array<prometheus::Histogram*, kStageCount> stages_{};
  std::array<prometheus::Counter*, kStateCount> answers_{};
  std::array<std::array<prometheus::Counter*, kFaultCount>, kKindCount> set_aside_{};
  std::array<prometheus::Counter*, kKindCount> answers_set_aside_{};
  std::array<prometheus::Counter*, kUseCount> fixes_{};
  prometheus::Histogram& scan_;
  prometheus::Histogram& edge_distance_;
  prometheus::Histogram& residual_scale_;
  prometheus::Histogram& overlap_;
  prometheus::Histogram& protection_level_;
  prometheus::Histogram& map_acquire_;
  prometheus::Counter& map_hits_;
  prometheus::Counter& map_misses_;
  prometheus::Counter& valid_edges_;
  prometheus::Counter& invalid_edges_;
  prometheus::Counter& wrong_beta_;
  prometheus::Counter& pose_resets_;
  prometheus::Counter& repeated_;
  prometheus::Counter& dropped_;
  prometheus::Counter& tickets_;
  prometheus::Counter& ticket_bytes_;
  prometheus::Counter& catch_up_scans_;
  std::array<prometheus::Counter*, kTicketUseNames.size()> ticket_uses_{};
  prometheus::Family<prometheus::Counter>& rejected_;
  prometheus::Family<prometheus::Counter>& opens_;
};

}  // namespace dcloc::server
