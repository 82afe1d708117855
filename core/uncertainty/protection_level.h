#pragma once

#include <algorithm>
#include <span>

#include "absl/status/status.h"
#include "core/geometry/pose.h"
#include "core/options/option_fields.h"

namespace dcloc {

/// What a protection level is made of.
struct ProtectionLevelOptions {
  /// The bound in standard deviations. A planar error exceeds it once in ten thousand times:
  /// sqrt(-2 ln 1e-4).
  double sigmas = 4.29;
  /// What the map and its frame err by, which no covariance contains.
  double floor_m = 0.15;
  /// How far back innovations count: the weight of an older one beside the next.
  double forgetting_factor = 0.9;
  double max_squared_sigmas = 100.0;  ///< the most that one innovation counts for
  /// The most that contradictions count for: so far off, a place is another one.
  double max_contradiction_m = 2.0;
  double contradiction_fades_m = 150.0;  ///< on so much of the way, to 1/e
};
std::span<const OptionField<ProtectionLevelOptions>> FieldsOf(
    const ProtectionLevelOptions& options);
absl::Status Validate(const ProtectionLevelOptions& options);

/// A bound of the horizontal error from the covariance and from how large innovations have been
/// beside what it let expect (METHOD eq 56).
class ProtectionLevel {
 public:
  explicit ProtectionLevel(const ProtectionLevelOptions& options) : options_(options) {}

  /// A registration differed so from its prediction: squared Mahalanobis distance per degree of
  /// freedom. It lies `residual_m` from the estimate that it has become a part of, in the
  /// vehicle's xy plane.
  void OnInnovation(double squared_distance_per_dof, const Eigen::Vector2d& residual_m);

  /// The pose was moved by `distance_m`, which is more than its covariance let expect. Either the
  /// pose before was wrong or this one is.
  void OnContradiction(double distance_m);

  /// The vehicle moved on.
  void OnMotion(double distance_m);

  /// How large innovations have been: the mean of what `OnInnovation` took.
  double mean_nis() const { return mean_nis_; }
  /// What `OnContradiction` took and has not faded.
  double contradiction_m() const { return contradiction_m_; }
  /// An earlier localizer of the same vehicle found these, both >= 0.
  void Restore(double mean_nis, double contradiction_m) {
    mean_nis_ = std::min(mean_nis, options_.max_squared_sigmas);
    contradiction_m_ = std::min(contradiction_m, options_.max_contradiction_m);
  }

  /// Of a pose of this covariance (x and y first) [m], which is off by up to `bias_m` beyond what
  /// the covariance says.
  double Of(const Matrix6d& covariance, double bias_m = 0.0) const;

  /// The same where nothing speaks against the covariance.
  double Usual(const Matrix6d& covariance) const;

 private:
  double Spread_m(const Matrix6d& covariance) const;

  ProtectionLevelOptions options_;
  double mean_nis_ = 1.0;  // per degree of freedom
  Eigen::Vector2d mean_residual_m_ = Eigen::Vector2d::Zero();
  double contradiction_m_ = 0.0;
};

}  // namespace dcloc
