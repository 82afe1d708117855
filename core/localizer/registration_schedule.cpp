#include "core/localizer/registration_schedule.h"

namespace dcloc {

std::span<const OptionField<RegistrationScheduleOptions>> FieldsOf(
    const RegistrationScheduleOptions& /*options*/) {
  using O = RegistrationScheduleOptions;
  static constexpr OptionField<O> kFields[] = {
      {"interval_ms", &O::interval, 0, 10'000, "each scan may be followed by a registration"},
      {"tracking_scans", &O::tracking_scans, 1, 100},
      {"max_interval_ms", &O::max_interval, 0, 10'000, "no scan is waited for"},
      {"min_new_points", &O::min_new_points, 0, 100'000, "old points alone are registered"},
      {"start_fraction", &O::start_fraction, 0, 1, "one scan is enough to begin with"},
      {"start_span_ms", &O::start_span, 0, 1e6, "one scan is enough to begin with"},
  };
  return kFields;
}

absl::Status Validate(const RegistrationScheduleOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

void RegistrationSchedule::OnScan(Stamp stamp, int submap_scan_count, std::size_t point_count) {
  newest_ = stamp;
  submap_scan_count_ = submap_scan_count;
  if (submap_scan_count == 1) submap_begin_ = stamp;
  ++scans_since_registration_;
  points_since_registration_ += point_count;
}

bool RegistrationSchedule::IsDue(bool is_steady) const {
  // A few points are easily registered wrong, and the better ones that follow then are outliers.
  const bool is_mature = submap_scan_count_ >= options_.start_fraction * full_scan_count_ ||
                         newest_ - submap_begin_ >= options_.start_span;
  if (!is_mature) return false;
  if (!last_registration_) return true;
  const std::chrono::nanoseconds since_last = newest_ - *last_registration_;
  if (is_steady && scans_since_registration_ < options_.tracking_scans &&
      since_last < options_.max_interval) {
    return false;
  }
  return since_last >= options_.interval;
}

void RegistrationSchedule::OnRegistration() {
  last_registration_ = newest_;
  scans_since_registration_ = 0;
  if (has_new_points()) points_since_registration_ = 0;
}

std::optional<std::chrono::nanoseconds> RegistrationSchedule::SinceRegistration() const {
  if (!last_registration_) return std::nullopt;
  return newest_ - *last_registration_;
}

}  // namespace dcloc
