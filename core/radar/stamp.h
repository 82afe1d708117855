#pragma once

#include <chrono>

namespace dcloc {

/// Time of a measurement, nanoseconds since the Unix epoch on the vehicle's clock.
using Stamp = std::chrono::sys_time<std::chrono::nanoseconds>;

/// A duration in seconds.
inline double SecondsOf(std::chrono::nanoseconds duration) {
  return std::chrono::duration<double>(duration).count();
}

}  // namespace dcloc
