#pragma once

#include <chrono>
#include <optional>
#include <vector>

#include "core/odometry/motion.h"
#include "core/radar/scan.h"

namespace dcloc {

/// How the vehicle moved of late, which can be asked for at any time of it: a scan that comes late
/// is placed where it was taken.
class MotionHistory {
 public:
  /// Keeps what lies no further back than `span`.
  explicit MotionHistory(std::chrono::nanoseconds span, const MotionOptions& options = {})
      : span_(span), options_(options) {}

  /// The vehicle moved so from the last stamp to `stamp`, which is not before it, and moves so now.
  void Add(Stamp stamp, const Motion& since_last, const EgoVelocity& velocity);

  bool empty() const { return entries_.empty(); }

  /// The vehicle at one moment.
  struct Moment {
    Motion to_newest;  ///< from then to the newest stamp
    EgoVelocity velocity;
  };
  /// At `stamp`, where it does not lie before or after all that is kept: between two stamps by the
  /// fraction of the time. Nothing else.
  std::optional<Moment> At(Stamp stamp) const;

  /// The same, and up to the same span after the newest stamp, if the vehicle goes on as it moves:
  /// there `to_newest` leads back.
  std::optional<Moment> AtOrSoonAfter(Stamp stamp) const;

 private:
  struct Entry {
    Stamp stamp;
    Motion since_last;
    EgoVelocity velocity;
  };
  std::chrono::nanoseconds span_;
  MotionOptions options_;
  std::vector<Entry> entries_;  // oldest first
};

}  // namespace dcloc
