#pragma once

#include <chrono>
#include <optional>

#include "core/radar/stamp.h"

namespace dcloc {

/// Decides which registrations are asked what they observe. Streets change slowly: one for each
/// sub-map is enough. But a registration that decides between sources of odometry is asked itself:
/// at the mouth of a tunnel it does not observe what the one before did.
class ObservabilitySchedule {
 public:
  /// Whether the registration at `stamp`, of a sub-map that covers `span`, is asked; then it counts
  /// as the last one that was. `is_decisive`: sources differ in where the vehicle is.
  bool IsDue(Stamp stamp, std::chrono::nanoseconds span, bool is_decisive) {
    const bool is_recent = last_ && stamp - *last_ <= span;
    if (is_recent && !is_decisive) return false;
    last_ = stamp;
    return true;
  }

 private:
  std::optional<Stamp> last_;
};

}  // namespace dcloc
