#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/options/option_fields.h"
#include "core/uncertainty/cumulative_sum.h"

namespace dcloc {

/// Which places along the road are held against the pose, and when one of them fits better.
struct AlongTrackRivalOptions {
  /// Places lie so far apart, from the first distance to the second, ahead and behind. Nearer ones
  /// are told apart by registration.
  double step_m = 0.25;
  double min_offset_m = 1.5;
  double max_offset_m = 24.0;
  /// Poses are compared as if they were as uncertain as this: steps shall miss no place.
  double pose_sigma_m = 0.3;
  /// By how much one point varies in what it adds to the difference of two fits.
  double point_sigma = 0.35;
  /// When a rival fits better for sure.
  CumulativeSumOptions better = {.drift = 1.5, .max = 3.5, .limit = 8.0};
  /// A pose is held against rivals until so many scans have been laid at a confirmed one.
  int scan_count = 15;
};
std::span<const OptionField<AlongTrackRivalOptions>> FieldsOf(
    const AlongTrackRivalOptions& options);
absl::Status Validate(const AlongTrackRivalOptions& options);

/// Holds the pose against places before and behind it. Where posts repeat, registration fits a
/// scan to the wrong ones as it does to the right ones. But what stands between them does not
/// repeat: laid into the map at both places, scans tell which of the two is right (METHOD eq 60).
class AlongTrackRivals {
 public:
  explicit AlongTrackRivals(const AlongTrackRivalOptions& options);

  /// Whether the next scan is to be compared, where the pose is confirmed or not yet.
  bool IsDue(bool is_confirmed) const {
    return !is_confirmed || confirmed_count_ < options_.scan_count;
  }

  /// As uncertain are poses to be taken that are compared [m].
  double pose_sigma_m() const { return options_.pose_sigma_m; }

  /// The places that are to be compared with a scan: how far each lies ahead of the pose [m].
  std::span<const double> offsets_m() const { return offsets_m_; }

  /// A scan of `point_count` points fits the map by `fit` where the vehicle is supposed to be, and
  /// at each of `offsets_m()` by `rival_fits`: [0, 1].
  void OnFits(std::size_t point_count, bool is_confirmed, double fit,
              std::span<const double> rival_fits);

  /// Whether scans fit another place better for sure.
  bool has_better() const;

  /// The vehicle is supposed to be somewhere else, or is where it was supposed to be.
  void Reset();

 private:
  AlongTrackRivalOptions options_;
  std::vector<double> offsets_m_;
  std::vector<CumulativeSum> better_;  // for each
  int confirmed_count_ = 0;            // of scans in a row
};

}  // namespace dcloc
