#include "core/localizer/time_base.h"

#include <algorithm>

#include "absl/strings/str_format.h"

namespace dcloc {

std::span<const OptionField<TimeBaseOptions>> FieldsOf(const TimeBaseOptions& /*options*/) {
  using O = TimeBaseOptions;
  static constexpr OptionField<O> kFields[] = {
      {"max_lateness_ms", &O::max_lateness, 0, 10'000, "late scans are refused"},
      {"scans_of_new_time", &O::scans_of_new_time, 1, 1000},
      {"new_time_span_ms", &O::new_time_span, 0, 1e6, "only scans of one stamp are a new time"},
      {"new_time_gap_ms", &O::new_time_gap, 0, 1e6, "no time has passed when a clock was set"},
      {"max_silence_ms", &O::max_silence, 1, 1e9},
  };
  return kFields;
}

absl::Status Validate(const TimeBaseOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

absl::StatusOr<TimeBase::ScanTime> TimeBase::ToMonotonic(Stamp stamp) {
  ScanTime time{.stamp = stamp + offset_};
  if (!newest_) {
    newest_ = stamp;
    return time;
  }
  const std::chrono::nanoseconds lateness = *newest_ - time.stamp;
  if (lateness > options_.max_lateness) {
    // In a new time stamps follow one another; scans that are merely late are scattered.
    const std::chrono::nanoseconds since_first = stamp - first_too_late_;
    const bool follows = too_late_in_a_row_ > 0 && since_first >= -options_.max_lateness &&
                         since_first <= options_.new_time_span;
    if (!follows) {
      too_late_in_a_row_ = 0;
      first_too_late_ = stamp;
    }
    if (++too_late_in_a_row_ < options_.scans_of_new_time) {
      using Milliseconds = std::chrono::duration<double, std::milli>;
      return absl::InvalidArgumentError(absl::StrFormat(
          "stamp is %d ns; it lies %.0f ms before the newest scan's, and must lie at most %.0f ms "
          "before it",
          stamp.time_since_epoch().count(), Milliseconds(lateness).count(),
          Milliseconds(options_.max_lateness).count()));
    }
    time.clock_was_set = true;
    time.stamp = *newest_ + options_.new_time_gap;
  }
  time.stamp = std::min(time.stamp, *newest_ + options_.max_silence);
  time.is_late = time.stamp < *newest_;
  if (!time.is_late) {
    newest_ = time.stamp;
    offset_ = time.stamp - stamp;
  }
  too_late_in_a_row_ = 0;
  return time;
}

}  // namespace dcloc
