#pragma once

#include <memory>

#include "server/convert/answer.h"
#include "server/sessions/health_watch.h"
#include "server/sessions/session_metrics.h"
#include "server/sessions/session_record.h"

namespace dcloc::server {

/// Tells operators of a session's health: the log, the metrics, and those who list sessions. Not
/// thread-safe.
class HealthReport {
 public:
  /// `metrics` outlives it.
  HealthReport(std::shared_ptr<SessionRecord> record, SessionMetrics& metrics)
      : record_(std::move(record)), metrics_(metrics) {}

  /// `scan` has a rig.
  void OnLocalized(const LocalizedScan& scan, HealthWatch::Clock::time_point now);

 private:
  const std::shared_ptr<SessionRecord> record_;
  SessionMetrics& metrics_;
  HealthWatch watch_;
};

}  // namespace dcloc::server
