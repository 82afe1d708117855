#pragma once

#include <Eigen/Core>
#include <array>
#include <bitset>
#include <span>
#include <vector>

#include "core/geometry/gaussian_point.h"
#include "core/geometry/pose.h"
#include "core/map/local_map.h"
#include "core/options/option_fields.h"
#include "core/registration/correspondences.h"
#include "core/registration/map_fit.h"

namespace dcloc {

/// When a direction counts as observed. Measured in streets, tunnels and dense maps (METHOD 9,
/// decision 0012).
struct ObservabilityOptions {
  int max_point_count = 300;  ///< points, evenly chosen, that the score is computed from
  // A shift along an observed direction, by one of two lengths, costs a fraction of the score. In
  // streets it is a third and more, between smooth walls nothing. Facades and rails in dense maps
  // look like themselves a metre further, but not three.
  double near_shift_m = 1.0;    ///< length of the short shift
  double near_min_drop = 0.05;  ///< fraction of the score that it costs at least, [0, 1]
  double far_shift_m = 3.0;     ///< length of the long shift
  double far_min_drop = 0.15;   ///< fraction of the score that it costs at least, [0, 1]
  /// A registration has this deviation along a direction that is not observed: far beyond what it
  /// can be off by.
  double degenerate_sigma_m = 10.0;
  // Along a blunt direction, a shift by `blunt_shift_m` costs less than `blunt_max_drop` of the
  // score. Along rails and walls of dense maps it costs a tenth, among posts and facades two
  // fifths.
  double blunt_shift_m = 0.5;   ///< length of the shift
  double blunt_max_drop = 0.2;  ///< fraction of the score, [0, 1]
  /// A registration has this deviation along a blunt direction for all that learns from it: it
  /// slides along with odometry, and catches up now and then.
  double blunt_sigma_m = 0.7;
};
std::span<const OptionField<ObservabilityOptions>> FieldsOf(const ObservabilityOptions& options);
absl::Status Validate(const ObservabilityOptions& options);

/// The horizontal axes of the vehicle frame: x along the track, y across it to the left.
enum class VehicleAxis { kX, kY };

/// Whether the points fit worse when a registration is shifted. The information matrix does not
/// show this: it takes each correspondence for the only possible one, but a point on a smooth wall
/// finds one that is as good anywhere along the wall.
struct Observability {
  struct Direction {
    Eigen::Vector2d axis;  ///< of length 1, in the vehicle's xy plane
    bool observed = true;
    bool blunt = false;
  };
  /// The directions of the registration's largest and smallest deviation, at right angles.
  std::array<Direction, 2> directions = {
      {{.axis = Eigen::Vector2d::UnitX()}, {.axis = Eigen::Vector2d::UnitY()}}};

  /// Whether an axis is observed: no more than half of it lies along a direction that is not.
  bool Observed(VehicleAxis axis) const;

  /// Of x, y, z, roll, pitch and yaw, in the plane or `in_space`.
  std::bitset<6> ObservedDof(bool in_space) const;

  /// Whether every direction is observed.
  bool ObservesAll() const { return directions[0].observed && directions[1].observed; }

  /// Covariance to be added to a registration's: `sigma_m` squared along the directions that are
  /// not observed.
  Eigen::Matrix2d DegeneracyCovariance(double sigma_m) const;

  /// The same along the directions that are blunt.
  Eigen::Matrix2d BluntCovariance(double sigma_m) const;
};

/// The observability of `live` (vehicle frame), registered at `T_local_vehicle` with `covariance`.
/// It is tested with a subset of the points; `options` are valid. `chosen` and `fit` provide
/// working memory.
template <int Dim>
Observability Observe(std::span<const GaussianPoint<Dim>> live, const LocalMap<Dim>& map,
                      const Pose<Dim>& T_local_vehicle, const TangentMatrix<Dim>& covariance,
                      const CorrespondenceGates& gates, const ObservabilityOptions& options,
                      std::vector<GaussianPoint<Dim>>& chosen, MapFit<Dim>& fit);

}  // namespace dcloc
