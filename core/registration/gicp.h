#pragma once

#include <span>

#include "absl/status/status.h"
#include "core/geometry/gaussian_point.h"
#include "core/geometry/pose.h"
#include "core/map/local_map.h"
#include "core/options/option_fields.h"
#include "core/registration/correspondences.h"
#include "core/registration/registration_method.h"

namespace dcloc {

struct GicpOptions {
  int max_iterations = 30;
  /// Landmarks further from a live point are not its correspondence.
  double max_correspondence_distance_m = 2.5;
  double gate_sigmas = 3.5;   ///< nor landmarks further in units of the joint deviation
  double huber_sigmas = 1.5;  ///< larger residuals have a smaller weight (Huber)
  double translation_tolerance_m = 1e-3;
  double rotation_tolerance_rad = 1e-4;
  /// Deviation that is added to every correspondence at first and halved in each iteration. It
  /// widens the basin of convergence. 0 for a good initial guess. `GicpRegistration` takes the
  /// deviation of the initial guess instead.
  double initial_blur_m = 0.0;
};
std::span<const OptionField<GicpOptions>> FieldsOf(const GicpOptions& options);
absl::Status Validate(const GicpOptions& options);

/// Uncertainty-aware GICP (METHOD eq 12): minimises sum rho_Huber(e^T W e) over the pose of `live`
/// (vehicle frame) in `map`, e = q - (R p + t), W = (S_q + R S_p R^T)^-1, correspondences being the
/// landmark of highest likelihood. Levenberg-Marquardt with W and the correspondences frozen within
/// an iteration (W for up to a milliradian, see CorrespondenceFinder); covariance and quality are
/// those of the last correspondences at the final pose. `finder` provides working memory.
template <int Dim>
Registration<Dim> RegisterGicp(std::span<const GaussianPoint<Dim>> live, const LocalMap<Dim>& map,
                               const Pose<Dim>& T_local_vehicle_initial, const GicpOptions& options,
                               CorrespondenceFinder<Dim>& finder);

/// The same with memory of its own.
template <int Dim>
Registration<Dim> RegisterGicp(std::span<const GaussianPoint<Dim>> live, const LocalMap<Dim>& map,
                               const Pose<Dim>& T_local_vehicle_initial,
                               const GicpOptions& options = {}) {
  CorrespondenceFinder<Dim> finder;
  return RegisterGicp<Dim>(live, map, T_local_vehicle_initial, options, finder);
}

}  // namespace dcloc
