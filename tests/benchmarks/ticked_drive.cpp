#include "tests/benchmarks/ticked_drive.h"

#include <chrono>
#include <cstdint>
#include <cstdlib>

#include "client/sdk/pose/motion_signals.h"

namespace dcloc::benchmarks {

Drive TickedDrive(const SimulatedPass& pass, double scan_rate_hz, int signals_a_tick) {
  Drive drive{.name = pass.drive.name, .place = pass.drive.place, .rig = pass.drive.rig};
  client::MotionSignals bus;
  const auto stride = static_cast<std::size_t>(signals_a_tick);
  std::size_t next = 0;  // signal
  std::int64_t last_ns = 0;
  for (const DriveScan& entry : pass.drive.scans) {
    const std::int64_t stamp_ns = entry.scan.stamp.time_since_epoch().count();
    if (static_cast<double>(stamp_ns - last_ns) < 1e9 / scan_rate_hz) continue;
    DriveScan& kept = drive.scans.emplace_back(entry);
    for (; stride > 0 && next < pass.signals.size(); next += stride) {
      const VehicleSignal& signal = pass.signals[next];
      const std::int64_t tick_ns = signal.stamp.time_since_epoch().count();
      if (!bus.Add({tick_ns, signal.speed_mps, signal.yaw_rate_radps}).ok()) std::abort();
      if (tick_ns > stamp_ns) break;
    }
    if (last_ns > 0) {
      const v1::MotionTicks ticks = bus.TicksAround(last_ns, stamp_ns);
      for (int i = 0; i < ticks.stamp_offset_ns_size(); ++i) {
        kept.scan.ticks.push_back({std::chrono::nanoseconds(ticks.stamp_offset_ns(i)),
                                   ticks.speed_mps(i), ticks.yaw_rate_radps(i)});
      }
    }
    last_ns = stamp_ns;
  }
  return drive;
}

}  // namespace dcloc::benchmarks
