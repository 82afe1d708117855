#pragma once

#include <chrono>

namespace dcloc {

/// Time of a measurement, nanoseconds since the Unix epoch on the vehicle's clock.
using Stamp = std::chrono::sys_time<std::chrono::nanoseconds>;

/// The latest stamp that is accepted, the year 2100. A clock beyond it is not set, and durations
/// between stamps up to it cannot overflow.
inline constexpr Stamp kMaxStamp{std::chrono::seconds(4'102'444'800)};

/// A duration in seconds.
inline double SecondsOf(std::chrono::nanoseconds duration) {
  return std::chrono::duration<double>(duration).count();
}

}  // namespace dcloc
