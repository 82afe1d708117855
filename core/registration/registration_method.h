#pragma once

#include <memory>
#include <optional>
#include <span>

#include "core/geometry/gaussian_point.h"
#include "core/geometry/pose.h"
#include "core/map/local_map.h"
#include "core/registration/registration_workspace.h"

namespace dcloc {

/// When a registration may stop.
struct RegistrationEffort {
  int max_iterations;
  double translation_tolerance_m;
  double rotation_tolerance_rad;
};

/// As much as it takes to compare places.
inline constexpr RegistrationEffort kComparingEffort{
    .max_iterations = 15, .translation_tolerance_m = 0.005, .rotation_tolerance_rad = 0.0005};

/// The input of a registration. All of it outlives the call.
template <int Dim>
struct RegistrationInput {
  std::span<const GaussianPoint<Dim>> points;  ///< of the sub-map, vehicle frame
  const LocalMap<Dim>& map;
  Pose<Dim> T_local_vehicle_guess;  ///< the initial guess
  /// Standard deviation of the guess's position, by which points are blurred at first; 0: it is
  /// good. Of the guess's rotation nothing is said.
  double guess_sigma_m = 0.0;
  std::optional<RegistrationEffort> effort = {};  ///< less than the method's own, where it has one
};

/// Variance [m^2, rad^2] that stands for "not observed".
inline constexpr double kUnobserved = 1e6;

/// The result of a registration: the pose of the points in the map. A method fills the pose, the
/// covariance and the last four fields. RegistrationGate (map_matcher.h) reads `inlier_count`,
/// `overlap` and `residual_scale`; METHOD eq 26 reads `score`. In the last two, d is the
/// Mahalanobis distance of a point to its correspondence, by the covariance
/// S_q + R S_p R^T of their difference and without Huber weights.
template <int Dim>
struct Registration {
  Pose<Dim> T_local_vehicle;
  /// In the tangent space on the right (METHOD eq 13-14), not inflated; a direction that the
  /// correspondences do not determine has a variance of `kUnobserved`.
  TangentMatrix<Dim> covariance;
  /// Reported only; not a criterion. What did not converge within the iterations has few inliers or
  /// large residuals.
  bool converged = false;
  int iterations = 0;    ///< reported only
  int inlier_count = 0;  ///< points with a correspondence inside of the gates
  double overlap = 0.0;  ///< share of all points that are inliers, [0, 1]
  double score = 0.0;    ///< mean of exp(-d^2 / 2) over all points; others than inliers add 0
  double residual_scale = 0.0;  ///< sqrt(mean of d^2 / Dim) over the inliers; 1: as modelled
};

/// The interface of a registration algorithm. Stateless: one object serves many vehicles at once,
/// and the result depends only on the input.
template <int Dim>
class RegistrationMethod {
 public:
  virtual ~RegistrationMethod() = default;

  /// Aligns `input.points`, of which there is at least one, with the map. If it does not converge,
  /// `converged` is false; without correspondences `inlier_count` is 0. `workspace` provides
  /// working memory.
  virtual Registration<Dim> Register(const RegistrationInput<Dim>& input,
                                     RegistrationWorkspace<Dim>& workspace) const = 0;

  /// Whether `Register` has called `workspace.finder.Begin` with the input's points and map, so
  /// that the caller need not.
  virtual bool PreparesFinder() const { return false; }
};

/// The methods of a localizer, in the plane and in space; null is ours, GicpRegistration.
struct RegistrationMethods {
  std::shared_ptr<const RegistrationMethod<2>> planar;
  std::shared_ptr<const RegistrationMethod<3>> spatial;

  template <int Dim>
  const std::shared_ptr<const RegistrationMethod<Dim>>& Of() const {
    if constexpr (Dim == 2) {
      return planar;
    } else {
      return spatial;
    }
  }
};

}  // namespace dcloc
