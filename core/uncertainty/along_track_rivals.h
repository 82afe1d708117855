#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/geometry/forgetting_mean.h"
#include "core/options/option_fields.h"
#include "core/uncertainty/one_sided_cusum.h"

namespace dcloc {

/// Which places along the road are held against the pose, and when one of them fits better.
struct AlongTrackRivalOptions {
  // Rivals lie ahead and behind. Nearer places are distinguished by registration.
  double step_m = 0.25;        ///< distance between neighbouring rivals
  double min_offset_m = 1.5;   ///< distance of the nearest rival from the pose
  double max_offset_m = 24.0;  ///< distance of the furthest one, at most; 0: no rivals
  /// Poses are compared as if they were as uncertain as this: steps shall miss no place.
  double pose_sigma_m = 0.3;
  /// Standard deviation of what one point adds to the difference of two fits.
  double point_sigma = 0.35;
  /// When a rival fits better for sure.
  OneSidedCusumOptions better = {.drift = 1.0, .max = 3.5, .limit = 8.0};
  int places_per_scan = 12;  ///< places that one scan is compared at
  int max_point_count = 50;  ///< of a scan's points, for as many are laid at each place
  /// A pose that begins is compared at this many times as many places, until each has had its turn
  /// `beginning_rounds` times.
  int beginning_factor = 3;
  int beginning_rounds = 3;
  /// The ground repeats where the best rival of a scan fits by this fraction of what the pose does,
  /// on average. In towns it fits by 0.3, on highways by 0.6.
  double repeating_fraction = 0.45;
  double forgetting_factor = 0.9;  ///< weight of an older scan beside the next, [0, 1)
};
std::span<const OptionField<AlongTrackRivalOptions>> FieldsOf(
    const AlongTrackRivalOptions& options);
absl::Status Validate(const AlongTrackRivalOptions& options);

/// Holds the pose against places before and behind it. Where posts repeat, registration fits a
/// scan to the wrong ones as it does to the right ones. But what stands between them does not
/// repeat: laid into the map at both places, scans show which of the two is right (METHOD eq 60).
class AlongTrackRivals {
 public:
  explicit AlongTrackRivals(const AlongTrackRivalOptions& options);

  /// As uncertain are poses to be taken that are compared [m].
  double pose_sigma_m() const { return options_.pose_sigma_m; }

  /// Of a scan, as many points are to be compared at most.
  int max_point_count() const { return options_.max_point_count; }

  /// Chooses where the next scan is to be compared: how far each place lies ahead of the pose [m],
  /// the pose itself first; none if there are no rivals. Up to half of the places have fitted
  /// better so far; the others take turns, so that each is compared now and then. Valid until the
  /// next call.
  std::span<const double> NextOffsets_m();

  /// `point_count` points of a scan fit the map by `fits` at the places chosen last: [0, 1].
  void OnFits(std::size_t point_count, std::span<const double> fits);

  /// The same fits, of a scan that lies in the map where the pose is.
  void LearnRepetition(std::span<const double> fits);

  /// Whether scans that fit here would fit places nearby, too.
  bool ground_repeats() const { return best_fraction_.mean >= options_.repeating_fraction; }

  /// Whether scans fit another place better for sure.
  bool has_better() const;

  /// The vehicle is supposed to be somewhere else, or is where it was supposed to be.
  void Reset();

 private:
  struct OffsetHypothesis {
    double offset_m = 0.0;
    OneSidedCusum better;
  };

  std::size_t CountToChoose() const;
  void Choose(std::size_t index);

  AlongTrackRivalOptions options_;
  std::vector<OffsetHypothesis> hypotheses_;
  std::size_t turn_ = 0;             // the hypothesis whose turn is next
  int round_count_ = 0;              // turns that each has had since the beginning
  std::vector<std::size_t> chosen_;  // of the hypotheses, for the next scan
  std::vector<double> chosen_offsets_m_;
  ForgettingMean best_fraction_;  // of the best rival's fit in that of the pose
};

}  // namespace dcloc
