#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/geometry/forgetting_mean.h"
#include "core/options/option_fields.h"
#include "core/uncertainty/one_sided_cusum.h"

namespace dcloc {

/// When a scan's fit is compared, and when it is too little.
struct MapFitOptions {
  int min_point_count = 12;         ///< of a scan; fewer say nothing
  int max_point_count = 150;        ///< of a scan, more are thinned
  int min_scan_count = 12;          ///< of a radar before anything is expected of it
  double forgetting_factor = 0.98;  ///< of older scans, some fifty
  /// Scans that must follow before one is learned from: with the next, as many as a decline takes
  /// at least. What waits when one shows is not learned from.
  int learning_delay = 4;
  // A fit contradicts the map if it lies below the expected one by both of these.
  double contradiction_sigmas = 3.5;  ///< in standard deviations of fits
  double contradiction_share = 0.4;   ///< as a share of the expected fit, [0, 1]
  double min_sigma = 0.04;            ///< fits vary by no less
  /// When scans have fitted less than expected for too long, each by a little.
  OneSidedCusumOptions decline;
  /// A prediction that is less certain is tested as if it were as certain as this.
  double max_prediction_sigma_m = 0.5;
};
std::span<const OptionField<MapFitOptions>> FieldsOf(const MapFitOptions& options);
absl::Status Validate(const MapFitOptions& options);

/// How a scan fits the map where the vehicle is predicted to be: as nothing is known to expect, as
/// it should, or worse.
enum class ScanFit { kUnknown, kAgrees, kContradicts };

/// What scan after scan says, each by too little to contradict: they fit as they should, less, or
/// so much less that it is no chance.
enum class FitTrend { kUsual, kDeclining, kDeclined };

/// Knows how well each radar's scans fit the map while the vehicle tracks, and so when one does not
/// fit (METHOD eq 51). Unlike a registration, a fit cannot be improved by moving the pose: the
/// prediction is tested as it is.
class MapFitMonitor {
 public:
  MapFitMonitor(std::size_t radar_count, const MapFitOptions& options)
      : options_(options), radars_(radar_count) {
    unlearned_.reserve(static_cast<std::size_t>(options.learning_delay) + 1);
  }

  /// What the fit of a scan of `point_count` points by radar `radar_index` says: the mean of
  /// exp(-d^2 / 2) over its points, [0, 1].
  ScanFit Judge(std::size_t radar_index, std::size_t point_count, double fit) const;

  /// Takes in the fit of such a scan, for `Trend`.
  void Follow(std::size_t radar_index, std::size_t point_count, double fit);

  /// METHOD eq 59.
  FitTrend Trend() const;

  /// Such a scan was taken where the vehicle surely is, as far as it is known yet.
  void Learn(std::size_t radar_index, std::size_t point_count, double fit);

  /// What was learned does not hold any more.
  void Reset();

 private:
  struct Fit {
    std::size_t radar_index;
    double value;
  };

  bool IsComparable(const ForgettingMean& expected, std::size_t point_count) const;
  double Sigma(const ForgettingMean& expected) const;

  MapFitOptions options_;
  std::vector<ForgettingMean> radars_;  // the fits of each
  std::vector<Fit> unlearned_;          // the newest, oldest first
  OneSidedCusum decline_;
};

}  // namespace dcloc
