#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/geometry/gaussian_point.h"
#include "core/geometry/pose.h"
#include "core/map/local_map.h"
#include "core/registration/correspondences.h"

namespace dcloc {

/// How well points lie in a local map: the mean of exp(-d^2 / 2), d being the Mahalanobis distance
/// of a point from its correspondence, and 0 for a point that has none (METHOD section 16). The
/// correspondences are those of `CorrespondenceFinder`, in single precision. For one pose or for
/// places far apart it is several times as fast, as it prepares nothing for poses nearby.
template <int Dim>
class MapFit {
 public:
  /// Turns points (vehicle frame) as they are seen at the heading of `T_local_vehicle`, from poses
  /// that are off by `sigma_m`. The map is to outlive the calls of `At`.
  void Begin(std::span<const GaussianPoint<Dim>> points, const LocalMap<Dim>& map,
             const CorrespondenceGates& gates, const Pose<Dim>& T_local_vehicle, double sigma_m);

  /// The fit with the vehicle at `p_local_m`: [0, 1], 0 without points.
  double At(const Eigen::Matrix<double, Dim, 1>& p_local_m) const;

  /// Whether the fit there is `max_fit` at most; soon known where it is far from that.
  bool IsAtMost(const Eigen::Matrix<double, Dim, 1>& p_local_m, double max_fit) const;

  /// The fit with the vehicle turned to the left by `turn_rad`, about the z axis of the local
  /// frame.
  double At(const Eigen::Matrix<double, Dim, 1>& p_local_m, double turn_rad) const;

 private:
  using Vector = Eigen::Matrix<float, Dim, 1>;
  using Matrix = Eigen::Matrix<float, Dim, Dim>;

  // A point as seen from the vehicle, along the axes of the local frame.
  struct Turned {
    Vector p_m;
    Vector slant_per_m;
    Matrix covariance_m2;  // with the pose's
  };

  float FitOf(const Turned& point, const Vector& p_m) const;

  const LocalMap<Dim>* map_ = nullptr;
  float max_distance_m_ = 0.0F;
  float gate_ = 0.0F;  // of squared Mahalanobis distances
  std::vector<Turned> points_;
};

}  // namespace dcloc
