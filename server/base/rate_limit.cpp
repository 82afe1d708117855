#include "server/base/rate_limit.h"

#include <algorithm>

namespace dcloc::server {

bool RateLimit::Take(double rate_hz, Clock::time_point now) {
  if (rate_hz <= 0.0) return true;
  const std::lock_guard lock(mutex_);
  const double capacity = std::max(1.0, rate_hz);
  if (begun_) {
    // Two threads may come with times in the other order.
    const double passed_s = std::max(0.0, std::chrono::duration<double>(now - last_).count());
    left_ = std::min(capacity, left_ + passed_s * rate_hz);
  } else {
    left_ = capacity;
    begun_ = true;
  }
  last_ = std::max(last_, now);
  if (left_ < 1.0) return false;
  left_ -= 1.0;
  return true;
}

}  // namespace dcloc::server
