#pragma once

#include <chrono>

namespace dcloc {

inline double SecondsOf(std::chrono::nanoseconds duration) {
  return std::chrono::duration<double>(duration).count();
}

}  // namespace dcloc
