#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/options/option_fields.h"

namespace dcloc {

/// Which places along the way are held against the pose, and when one of them fits better.
struct WayRivalOptions {
  /// Places lie so far apart, from the first distance to the second, ahead and behind. Nearer ones
  /// are told apart by registration.
  double step_m = 0.25;
  double min_way_m = 1.5;
  double max_way_m = 24.0;
  /// Poses are compared as if they were as uncertain as this: steps shall miss no place.
  double pose_sigma_m = 0.3;
  /// By how much one point varies in what it adds to the difference of two fits.
  double point_sigma = 0.35;
  /// Each scan counts by how far a rival fits better, less `drift_sigmas`, and at most
  /// `max_sigmas`, until the sum exceeds `limit_sigmas` or falls below 0.
  double drift_sigmas = 1.0;
  double max_sigmas = 3.5;
  double limit_sigmas = 5.0;
  /// A pose is held against rivals until so many scans have been laid at a confirmed one.
  int scan_count = 15;
};
std::span<const OptionField<WayRivalOptions>> FieldsOf(const WayRivalOptions& options);
absl::Status Validate(const WayRivalOptions& options);

/// Holds the pose against places before and behind it. Where posts repeat, registration fits a
/// scan to the wrong ones as it does to the right ones. But what stands between them does not
/// repeat: laid into the map at both places, scans tell which of the two is right. A cumulative sum
/// for each place (Page 1954; METHOD eq 57).
class WayRivals {
 public:
  explicit WayRivals(const WayRivalOptions& options);

  /// Whether the next scan is to be compared, where the pose is confirmed or not yet.
  bool IsDue(bool is_confirmed) const {
    return !is_confirmed || confirmed_count_ < options_.scan_count;
  }

  /// As uncertain are poses to be taken that are compared [m].
  double pose_sigma_m() const { return options_.pose_sigma_m; }

  /// The places that are to be compared with a scan: how far each lies ahead of the pose [m].
  std::span<const double> ways_m() const { return ways_m_; }

  /// A scan of `point_count` points fits the map by `fit` where the vehicle is supposed to be, and
  /// at each of `ways_m()` by `rival_fits`: [0, 1].
  void OnFits(std::size_t point_count, bool is_confirmed, double fit,
              std::span<const double> rival_fits);

  /// The way [m] to a place that scans fit better for sure; nothing while there is none.
  std::optional<double> Better() const;

  /// The vehicle is supposed to be somewhere else.
  void Reset();

 private:
  WayRivalOptions options_;
  std::vector<double> ways_m_;
  std::vector<double> sums_sigmas_;  // for each
  int confirmed_count_ = 0;          // of scans in a row
};

}  // namespace dcloc
