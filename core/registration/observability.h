#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "core/geometry/gaussian_point.h"
#include "core/geometry/pose.h"
#include "core/map/local_map.h"
#include "core/registration/correspondences.h"

namespace dcloc {

/// Whether points fit worse where a registration is shifted. The information matrix of matched
/// points cannot tell: it takes each correspondence for the only possible one, where the points of
/// a smooth wall find others as good wherever they are put along it.
struct Observability {
  struct Direction {
    Eigen::Vector2d axis;  ///< of length 1, in the vehicle's xy plane
    bool observed = true;
  };
  /// At right angles: the registration's largest and smallest deviation.
  std::array<Direction, 2> directions = {
      {{.axis = Eigen::Vector2d::UnitX()}, {.axis = Eigen::Vector2d::UnitY()}}};

  /// Whether the vehicle's x or y axis (0, 1) is observed: no more than half of it lies along a
  /// direction that is not.
  bool Observed(int axis) const;

  /// Variances that take a registration's word in the directions that it does not observe.
  Eigen::Matrix2d DegeneracyCovariance() const;
};

/// Of `live` (vehicle frame) registered at `T_local_vehicle` with `covariance`. Some of the points
/// say it well enough; `chosen` and `finder` lend their memory.
template <int Dim>
Observability Observe(std::span<const GaussianPoint<Dim>> live, const LocalMap<Dim>& map,
                      const Pose<Dim>& T_local_vehicle, const TangentMatrix<Dim>& covariance,
                      const CorrespondenceGates& gates, std::vector<GaussianPoint<Dim>>& chosen,
                      CorrespondenceFinder<Dim>& finder);

}  // namespace dcloc
