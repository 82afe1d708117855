#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <span>

#include "absl/status/status.h"
#include "core/options/option_fields.h"
#include "core/radar/stamp.h"

namespace dcloc {

/// Which scans are followed by a registration.
struct RegistrationScheduleOptions {
  /// Radars of a rig that follow one another faster than this share a registration.
  std::chrono::nanoseconds interval = std::chrono::milliseconds(40);
  /// New scans that the next registration waits for while tracking, after one that was accepted:
  /// the more scans two sub-maps have in common, the less the second one says.
  int tracking_scans = 2;
  /// It waits for them no longer than this.
  std::chrono::nanoseconds max_interval = std::chrono::milliseconds(180);
  /// A sub-map with fewer new points than this is not registered: it would show how odometry moves
  /// old points, not where the vehicle is.
  int min_new_points = 10;
  /// Fraction of a full sub-map that registration waits for, at the start and after a gap.
  double start_fraction = 0.8;
  /// The longest that it waits for that.
  std::chrono::nanoseconds start_span = std::chrono::milliseconds(1000);
};
std::span<const OptionField<RegistrationScheduleOptions>> FieldsOf(
    const RegistrationScheduleOptions& options);
absl::Status Validate(const RegistrationScheduleOptions& options);

/// Counts scans and says when the next registration is due.
class RegistrationSchedule {
 public:
  /// A full sub-map has `full_scan_count` scans.
  RegistrationSchedule(const RegistrationScheduleOptions& options, int full_scan_count)
      : options_(options), full_scan_count_(full_scan_count) {}

  /// A scan of `point_count` static points at `stamp` was added to the sub-map, which then had
  /// `submap_scan_count` scans.
  void OnScan(Stamp stamp, int submap_scan_count, std::size_t point_count);

  /// A scan of `point_count` static points was added that was taken before the newest one. No
  /// registration has used them: they are as new as any.
  void OnLateScan(std::size_t point_count) { points_since_registration_ += point_count; }

  /// Whether the scan that was given last is to be followed by a registration. `is_steady`:
  /// tracking, and the newest registration was accepted.
  bool IsDue(bool is_steady) const;

  /// Whether enough static points have come since they last had.
  bool has_new_points() const {
    return points_since_registration_ >= static_cast<std::size_t>(options_.min_new_points);
  }

  /// The scan that was given last has been followed by a registration.
  void OnRegistration();

  /// From the first scan since the sub-map was empty to the newest one. Of fast radars a full
  /// sub-map spans less.
  std::chrono::nanoseconds SinceBegin() const { return newest_ - submap_begin_; }

  /// From the newest registration to the newest scan; nothing before the first one.
  std::optional<std::chrono::nanoseconds> SinceRegistration() const;

 private:
  RegistrationScheduleOptions options_;
  int full_scan_count_;
  Stamp newest_{};
  Stamp submap_begin_{};  // of the first scan since the sub-map was empty
  int submap_scan_count_ = 0;
  int scans_since_registration_ = 0;
  std::size_t points_since_registration_ = 0;
  std::optional<Stamp> last_registration_;
};

}  // namespace dcloc
