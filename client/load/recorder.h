#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "client/load/answer_check.h"
#include "client/load/latency_histogram.h"
#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::load {

/// A count of events, with the message of the first one.
struct Incidents {
  std::int64_t count = 0;
  std::string first;

  void Note(const std::string& text) {
    if (count++ == 0) first = text;
  }
};

/// Counts of a run's scans. Only scans of the measured time count, except for sessions and faults.
struct LoadTotals {
  std::int64_t answered_count = 0;
  std::int64_t repeated_count = 0;      ///< answered from memory
  std::int64_t late_refused_count = 0;  ///< sent behind their follower, and refused for it
  std::int64_t dropped_count = 0;       ///< refused for newer ones (drop-oldest)
  std::int64_t skipped_count = 0;       ///< never sent: the vehicle's own queue was full
  std::int64_t lost_count = 0;          ///< sent, and never answered
  std::int64_t opened_count = 0;        ///< sessions
  std::int64_t moved_count = 0;         ///< sessions that went on in another map version
  std::int64_t restart_count = 0;       ///< sessions begun anew, as the server had lost them
  std::int64_t disconnect_count = 0;    ///< connections that were broken on purpose
  std::int64_t stall_count = 0;         ///< likewise
  std::int64_t tracking_count = 0;
  std::int64_t lost_state_count = 0;  ///< answers that say LOST
  std::int64_t misleading_count = 0;
  std::int64_t judged_count = 0;  ///< compared with the truth
  double error_sum_m = 0.0;       ///< of those
  double max_error_m = 0.0;
  Incidents refused;     ///< scans, for other reasons than the above
  Incidents broken;      ///< streams that ended otherwise than they should
  Incidents violations;  ///< answers that break the contract

  double MeanErrorM() const {
    return judged_count == 0 ? 0.0 : error_sum_m / static_cast<double>(judged_count);
  }
};

/// One second of a run.
struct LoadSecond {
  double time_s = 0.0;  ///< its end, since the measuring began
  int vehicle_count = 0;
  std::int64_t answered_count = 0;
  double p50_ms = 0.0;
  double p99_ms = 0.0;
  double max_ms = 0.0;
};

/// All results of a run.
struct LoadRecord {
  LoadTotals totals;
  LatencyHistogram latency;         ///< from when a scan was due until its answer was there
  LatencyHistogram server_latency;  ///< the server's own part of it
  LatencyHistogram open_latency;    ///< from the call until the session was open
  LatencyHistogram gap;             ///< between two answers to one vehicle
  std::vector<LoadSecond> seconds;
};

/// Collects what the vehicles see. Thread-safe; each call takes well below a microsecond.
class Recorder {
 public:
  using Clock = std::chrono::steady_clock;

  /// From now on scans count.
  void Begin();
  /// From now on they do not.
  void End();

  void AddOpened(std::chrono::nanoseconds duration);
  void AddEnded();
  /// `latency` counts unless it is the vehicle's own fault.
  void AddAnswer(const v1::LocalizeResponse& answer, std::chrono::nanoseconds latency,
                 bool counts_latency);
  void AddError(const PositionError& error);
  /// Time without an answer to a vehicle; counts also if it ends after the measured time.
  void AddGap(Clock::time_point from, Clock::time_point to);
  void AddRepeated();
  void AddLateRefused();
  void AddRejected(const v1::ScanRejected& rejected);
  void AddSkipped();
  void AddLost(std::int64_t count);
  void AddMoved();
  void AddRestarted();
  void AddDisconnect();
  void AddStall();
  void AddBroken(const std::string& text);
  void AddViolation(const std::string& text);

  /// Ends the second that is under way and gives it; call it once a second.
  LoadSecond EndSecond();

  LoadRecord record() const;

 private:
  mutable std::mutex mutex_;
  LoadRecord record_;
  LatencyHistogram second_;
  Clock::time_point begin_;
  int vehicle_count_ = 0;
  bool measuring_ = false;
};

}  // namespace dcloc::load
