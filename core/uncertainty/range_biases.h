#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/geometry/gaussian_point.h"
#include "core/odometry/rig_knowledge.h"
#include "core/odometry/scalar_estimate.h"
#include "core/options/option_fields.h"

namespace dcloc {

/// When a radar's ranges are corrected by what the map says of them.
struct RangeBiasOptions {
  int scan_interval = 2;          ///< one of so many scans of a radar is compared
  int min_point_count = 12;       ///< of a scan; fewer say nothing
  int max_point_count = 100;      ///< of a scan, more are thinned
  double step_m = 0.4;            ///< by how much ranges are tried shorter and longer
  double max_correction_m = 0.6;  ///< at once
  /// Scans from so much of the way are one reading: the next ones see other landmarks.
  double reading_m = 10.0;
  // The weight of an older reading beside the next: where a bias is suspected, and where it is
  // corrected, because it began lately or because it shows in many readings.
  double suspicion_forgetting_factor = 0.5;
  double short_forgetting_factor = 0.75;
  double long_forgetting_factor = 0.95;
  int min_reading_count = 3;
  double reuse = 1.0;  ///< readings that see the same landmarks, so not independent
  /// Variance of what one point adds to the difference of two fits.
  double point_variance = 0.1;
  /// Of fits, by how much those of changed ranges lie lower where these are right. Where they do
  /// not, the bias is far off, and its size is not told.
  double min_decrease = 0.02;
  double landmark_sigma_m = 0.2;  ///< of landmarks, beside the points' own deviations
  // The smallest correction: the first one, those of a radar that is known to be off, and both in
  // standard deviations. Recordings of other radars than those of the map seem to be off by 0.3 m.
  double min_correction_m = 0.5;
  double min_next_correction_m = 0.1;
  double correction_sigmas = 4.0;
  double next_correction_sigmas = 2.5;
  /// From so many deviations on, a bias whose size is not told may be as large as any.
  double suspicion_sigmas = 2.0;
  double corrected_sigma_m = 0.05;  ///< a bias that was learned is known no better
  /// A bias of which as many readings have said nothing else is not doubted with the place.
  int established_reading_count = 10;
  /// Where no place was ever found, all radars may be off alike, by this.
  double guess_m = 0.5;
  double guess_sigma_m = 0.2;
  double max_bias_m = kMaxKnownRangeBiasError_m;  ///< no bias is taken for larger
};
std::span<const OptionField<RangeBiasOptions>> FieldsOf(const RangeBiasOptions& options);
absl::Status Validate(const RangeBiasOptions& options);

/// How well a scan fits the map with its ranges shorter by a step, as measured, and longer: [0, 1].
struct RangeFits {
  std::size_t point_count = 0;
  double shorter = 0.0;
  double as_measured = 0.0;
  double longer = 0.0;
};

/// Learns by how much each radar's ranges are too long. A pose absorbs most of that: where all
/// targets lie ahead, the vehicle seems to be further back. But a street looks wider than it is,
/// too, and that no pose absorbs (METHOD section 24).
class RangeBiases {
 public:
  RangeBiases(std::size_t radar_count, const RangeBiasOptions& options)
      : options_(options), radars_(radar_count) {}

  const RangeBiasOptions& options() const { return options_; }

  /// The vehicle moved on.
  void OnMotion(double distance_m);

  /// A scan of radar `index`, of `point_count` points. Returns whether it is to be compared.
  bool IsDue(std::size_t index, std::size_t point_count);

  /// A scan of radar `index` that is due fits so. Of each metre that its ranges are too long, a
  /// pose absorbs `absorbed_m`; nothing if the radar has no part in it. Returns by how much the
  /// bias has been corrected [m], if it has been.
  std::optional<double> OnFits(std::size_t index, const RangeFits& fits, double absorbed_m);

  /// By how much the ranges of radar `index` are longer than its description says, if that is
  /// known.
  const std::optional<ScalarEstimate>& bias_m(std::size_t index) const {
    return radars_[index].bias_m;
  }

  /// By how much a pose may be off because of biases that are not corrected yet.
  double suspected_m() const;

  /// An earlier session found this bias of radar `index`.
  void Restore(std::size_t index, const ScalarEstimate& bias_m);

  /// The vehicle is somewhere else than was supposed: scans that were compared do not count.
  void Reset();

  /// Nothing in the map looks like what the radars see. What was learned may be of a wrong pose: of
  /// each radar whose bias was ever known, and is not established, the other is tried, that one or
  /// the described one. Returns whether there are such radars.
  bool TryOther();

  /// Whether no scan was ever compared, and what biases there are, if any, are guesses.
  bool KnowsNothing() const;

  /// Where it knows nothing: the ranges of all radars are supposed to be longer than described, the
  /// next time shorter, then as described again.
  void Guess();

 private:
  // Sums over readings, older ones weighing less.
  struct Readings {
    double points = 0.0;
    double lean = 0.0;      // of how much better shorter ranges fit than longer ones
    double decrease = 0.0;  // of how much better measured ranges fit than both
    double lean_lean = 0.0, lean_points = 0.0, points_points = 0.0;  // of products
    double noise = 0.0;  // variance of the lean that single points cause
    int count = 0;
  };
  struct Radar {
    std::optional<ScalarEstimate> bias_m, other_m;
    int scan_count = 0;
    double distance_m = 0.0;                          // of the reading that is being made
    double points = 0.0, lean = 0.0, decrease = 0.0;  // its sums
    Readings newest, recent, many;
    double suspected_m = 0.0;  // how far off a pose may be because of it
    int readings_since_correction = 0;
  };
  void EndReading(Radar& radar) const;
  ScalarEstimate Bounded(const ScalarEstimate& bias_m) const;
  void Add(const Radar& radar, double forgetting_factor, Readings& readings) const;
  double SuspectedBias_m(const Readings& readings) const;
  // By how much ranges seem to be longer than corrected for, and its variance.
  ScalarEstimate Remaining(const Readings& readings) const;
  bool IsSure(const Radar& radar, const ScalarEstimate& remaining_m) const;

  RangeBiasOptions options_;
  std::vector<Radar> radars_;
  bool was_compared_ = false;
  int guess_count_ = 0;
};

/// What a metre more of range does to points (vehicle frame, in x and y) of a radar at `radar_m`
/// that no motion of the vehicle does, to `shifts_m`, in their order. Returns the length of the
/// motion that does the rest.
template <int Dim>
double ShiftsByRange(std::span<const GaussianPoint<Dim>> points, const Eigen::Vector2d& radar_m,
                     double landmark_sigma_m, std::vector<Eigen::Vector2d>& shifts_m);

}  // namespace dcloc
