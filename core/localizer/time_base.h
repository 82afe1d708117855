#pragma once

#include <algorithm>
#include <chrono>
#include <optional>
#include <span>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/options/option_fields.h"
#include "core/radar/stamp.h"

namespace dcloc {

/// What of a vehicle's clock is taken as it is.
struct TimeBaseOptions {
  /// Scans that come at most this late are still taken at their stamp.
  std::chrono::nanoseconds max_lateness = std::chrono::milliseconds(250);
  int scans_of_new_time = 3;  ///< scans in a row, later than that, that show a clock set back
  /// The longest time that these scans span, by their own stamps.
  std::chrono::nanoseconds new_time_span = std::chrono::seconds(2);
  /// The time that has then passed since the newest scan.
  std::chrono::nanoseconds new_time_gap = std::chrono::milliseconds(100);
  /// A longer silence is as one of this length.
  std::chrono::nanoseconds max_silence = std::chrono::minutes(1);
};
std::span<const OptionField<TimeBaseOptions>> FieldsOf(const TimeBaseOptions& options);
absl::Status Validate(const TimeBaseOptions& options);

/// Makes the stamps of a vehicle's scans, which come late and out of order and whose clock may be
/// set, a time that everything else can rely on. While the clock is not set it is the scans' own.
class TimeBase {
 public:
  explicit TimeBase(const TimeBaseOptions& options = {}) : options_(options) {}

  struct ScanTime {
    Stamp stamp;           ///< in the time that does not go back
    bool is_late = false;  ///< before the newest scan, by at most `max_lateness`
    bool clock_was_set = false;
  };
  /// When a scan of this stamp was taken; time moves on to it. InvalidArgument, with the stamp and
  /// the bound, for one that comes too late, unless the clock is found to have been set.
  absl::StatusOr<ScanTime> ToMonotonic(Stamp stamp);

  /// A stamp of the vehicle's clock as it is set now, in the time that does not go back.
  Stamp Convert(Stamp stamp) const { return stamp + offset_; }

  /// For how long there would have been no scan, if the next one were taken at `stamp`.
  std::chrono::nanoseconds SilenceBefore(Stamp stamp) const {
    return std::min(Convert(stamp) - newest(), options_.max_silence);
  }

  /// The inverse of `Convert`.
  Stamp OnVehicleClock(Stamp time) const { return time - offset_; }

  /// Goes on after a scan of that stamp. Before the first one.
  void Restore(Stamp newest) { newest_ = newest; }

  /// The newest scan's, in the time that does not go back; the epoch before the first one.
  Stamp newest() const { return newest_.value_or(Stamp{}); }

 private:
  TimeBaseOptions options_;
  std::chrono::nanoseconds offset_{0};  // of the time to the vehicle's clock
  std::optional<Stamp> newest_;
  int too_late_in_a_row_ = 0;
  Stamp first_too_late_{};
};

}  // namespace dcloc
