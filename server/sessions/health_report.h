#pragma once

#include <memory>

#include "server/convert/answer.h"
#include "server/sessions/health_watch.h"
#include "server/sessions/session_info.h"
#include "server/sessions/session_metrics.h"

namespace dcloc::server {

/// Tells operators of a session's health: the log, the metrics, and those who list sessions. Not
/// thread-safe.
class HealthReport {
 public:
  /// `metrics` outlives it.
  HealthReport(std::shared_ptr<SessionInfo> info, SessionMetrics& metrics)
      : info_(std::move(info)), metrics_(metrics) {}

  /// `scan` has a rig.
  void OnLocalized(const LocalizedScan& scan, HealthWatch::Clock::time_point now);

 private:
  const std::shared_ptr<SessionInfo> info_;
  SessionMetrics& metrics_;
  HealthWatch watch_;
};

}  // namespace dcloc::server
