#include "client/load/load_options.h"

#include "client/datasets/files/check_range.h"

namespace dcloc::load {
namespace {

constexpr double kDay_ms = 86'400'000.0;

template <typename Duration>
absl::Status CheckDuration(const char* field, Duration duration, double min_ms) {
  return CheckRange(field, std::chrono::duration<double, std::milli>(duration).count(), min_ms,
                    kDay_ms);
}

}  // namespace

absl::Status Validate(const LoadOptions& options) {
  const FaultProfile& faults = options.faults;
  absl::Status status = CheckRange("vehicle_count", options.vehicle_count, 1, 100'000);
  status.Update(CheckDuration("duration", options.duration, 1.0));
  status.Update(CheckDuration("warmup", options.warmup, 0.0));
  status.Update(CheckDuration("ramp", options.ramp, 0.0));
  status.Update(CheckDuration("drain", options.drain, 0.0));
  status.Update(CheckDuration("arrival_jitter", options.arrival_jitter, 0.0));
  status.Update(CheckRange("pace", options.pace, 0.01, 1000.0));
  status.Update(CheckRange("begin_within", options.begin_within, 0.0, 1.0));
  status.Update(CheckRange("faults.disconnects_per_min", faults.disconnects_per_min, 0.0, 600.0));
  status.Update(CheckRange("faults.stalls_per_min", faults.stalls_per_min, 0.0, 600.0));
  status.Update(CheckDuration("faults.stall_duration", faults.stall_duration, 1.0));
  status.Update(CheckRange("faults.slow_reader_share", faults.slow_reader_share, 0.0, 1.0));
  status.Update(CheckDuration("faults.slow_read_interval", faults.slow_read_interval, 1.0));
  status.Update(CheckRange("faults.duplicate_share", faults.duplicate_share, 0.0, 1.0));
  status.Update(CheckRange("faults.reorder_share", faults.reorder_share, 0.0, 1.0));
  return status;
}

}  // namespace dcloc::load
