#pragma once

#include <chrono>
#include <cstdint>

#include "absl/status/status.h"
#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::load {

/// Faults that are injected. Rates are per vehicle; shares are of all scans or vehicles, [0, 1].
struct FaultProfile {
  double disconnects_per_min = 0.0;  ///< the connection is reset, and the session resumed
  double stalls_per_min = 0.0;       ///< nothing is sent for a while, then all that is due
  std::chrono::milliseconds stall_duration{1000};
  double slow_reader_share = 0.0;  ///< of the vehicles: they take an answer now and then
  std::chrono::milliseconds slow_read_interval{500};
  double duplicate_share = 0.0;  ///< of the scans: sent twice
  double reorder_share = 0.0;    ///< of the scans: sent behind the one that follows

  bool any() const {
    return disconnects_per_min > 0.0 || stalls_per_min > 0.0 || slow_reader_share > 0.0 ||
           duplicate_share > 0.0 || reorder_share > 0.0;
  }
};

/// How a server is loaded.
struct LoadOptions {
  int vehicle_count = 10;
  /// Open loop: each scan is sent when it is due, whether or not the server keeps up. Closed loop:
  /// each is sent as soon as the one before is answered.
  bool open_loop = true;
  std::chrono::milliseconds duration = std::chrono::seconds(20);  ///< that is measured
  std::chrono::milliseconds warmup = std::chrono::seconds(2);  ///< before it, once all have begun
  std::chrono::milliseconds ramp = std::chrono::seconds(2);    ///< the vehicles begin within it
  std::chrono::milliseconds drain = std::chrono::seconds(5);   ///< for the last answers
  std::chrono::microseconds arrival_jitter = std::chrono::milliseconds(5);
  double pace = 1.0;          ///< recorded seconds in one of ours; open loop only
  double begin_within = 1.0;  ///< share of its drive, from the start, in which a vehicle begins
  v1::QueuePolicy queue_policy = v1::QUEUE_POLICY_BLOCK;
  FaultProfile faults;
  std::uint64_t seed = 1;  ///< of jitter, faults and where on its drive a vehicle begins
};

/// OK, or InvalidArgument naming the field, the value and the bound.
absl::Status Validate(const LoadOptions& options);

}  // namespace dcloc::load
