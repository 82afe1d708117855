#pragma once

#include <optional>
#include <span>

#include "absl/status/status.h"
#include "core/geometry/pose_estimate.h"
#include "core/odometry/motion.h"
#include "core/options/option_fields.h"
#include "core/relocalization/place_search.h"

namespace dcloc {

/// Poses less certain than this are no prediction: the ground and the headings that they leave are
/// searched like a whole map.
struct PosePriorOptions {
  double max_prediction_sigma_m = 3.5;
  double max_prediction_sigma_rad = 0.2;
  /// Radius of the search region in standard deviations: a position is further off once in 450
  /// times.
  double region_sigmas = 3.5;
  double max_region_radius_m = 150.0;  ///< wider ones are searched with the whole map
  // A region in which the vehicle has not been found was too small: it grows, and every heading is
  // searched.
  double region_growth_m = 10.0;      ///< added to the radius first
  double region_growth_factor = 3.0;  ///< on the sum, for each search in vain
};
std::span<const OptionField<PosePriorOptions>> FieldsOf(const PosePriorOptions& options);
absl::Status Validate(const PosePriorOptions& options);

/// What is known of a vehicle that no registration has found yet, or none finds any more: a prior
/// or the last estimate, carried on by odometry.
class PosePrior {
 public:
  explicit PosePrior(const PosePriorOptions& options) : options_(options) {}

  /// The vehicle is about here now, in the map frame.
  void Set(const PoseEstimate<3>& T_map_vehicle);

  /// Carries the pose on by the vehicle's `motion`.
  void OnMotion(const Motion& motion);

  /// It has been found, or nothing is known of it.
  void Reset() { now_.reset(); }

  const std::optional<PoseEstimate<3>>& now() const { return now_; }

  /// Whether registrations can start from a pose that is known so well, so that nothing must be
  /// searched.
  bool IsPrediction(const Matrix6d& covariance) const;

  /// The positions and headings to search, after `failed_search_count` searches without a result.
  /// They are those of the moment of `Set`; `T_then_now` is the better known motion since then.
  /// The radius is at least `min_radius_m`, which grows from the second such search on. Nothing
  /// without a prior, or when the radius exceeds `max_region_radius_m`.
  std::optional<SearchRegion> Region(int failed_search_count = 0, double min_radius_m = 0.0) const;

 private:
  PosePriorOptions options_;
  std::optional<PoseEstimate<3>> now_;
  PoseEstimate<3> then_;  // when it was set
  Motion since_then_;
};

}  // namespace dcloc
