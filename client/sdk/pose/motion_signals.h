#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <set>

#include "absl/status/status.h"
#include "dcloc/v1/scan.pb.h"

namespace dcloc::client {

/// What wheels, or a gyroscope, or both say at one moment.
struct MotionTick {
  std::int64_t stamp_ns = 0;             ///< on the clock of the scans
  std::optional<double> speed_mps;       ///< forward, of the vehicle frame's origin
  std::optional<double> yaw_rate_radps;  ///< counter-clockwise
};

/// The vehicle's speed and yaw rate over time, each from ticks at a rate of its own. Keeps the last
/// second. Not thread-safe.
class MotionSignals {
 public:
  /// Takes a tick, which may come somewhat late. InvalidArgument names the field and the value. A
  /// stamp a second before the newest one says that the clock was set back, and starts over.
  absl::Status Add(const MotionTick& tick);

  /// Both at a stamp: between ticks on a straight line, up to 0.1 s after the newest or before the
  /// oldest as that says. Nothing where either is not known.
  std::optional<v1::EgoVelocity> VelocityAt(std::int64_t stamp_ns) const;

  /// The ticks around the time from `from_ns` to the scan at `to_ns`, as they go with it: those of
  /// both signals, each with what the other one says at its stamp. Some 200 at most, evenly taken;
  /// none for a time of more than a second.
  v1::MotionTicks TicksAround(std::int64_t from_ns, std::int64_t to_ns) const;

 private:
  struct Sample {
    std::int64_t stamp_ns = 0;
    double value = 0.0;
  };
  using Signal = std::deque<Sample>;  ///< by ascending stamp

  static void Insert(const Sample& sample, Signal& signal);
  static void AddAround(const Signal& signal, std::int64_t from_ns, std::int64_t to_ns,
                        std::set<std::int64_t>& stamps_ns);
  static std::optional<double> At(const Signal& signal, std::int64_t stamp_ns);

  Signal speed_mps_;
  Signal yaw_rate_radps_;
  std::int64_t newest_ns_ = 0;
};

}  // namespace dcloc::client
