#pragma once

#include <chrono>
#include <span>

#include "absl/status/status.h"
#include "core/options/option_fields.h"
#include "core/posegraph/pose_graph.h"
#include "core/registration/registration_method.h"

namespace dcloc {

/// Errors that all points of a registration share: of the map, of mounts and of clocks. More points
/// do not reduce them. They are constant for `shared_time`, so that several registrations within it
/// do not average them out.
struct RegistrationFactorOptions {
  double shared_sigma_m = 0.08;     ///< standard deviation of the position by these errors
  double shared_sigma_rad = 0.003;  ///< standard deviation of the heading by these errors
  /// The time for which these errors are constant.
  std::chrono::nanoseconds shared_time = std::chrono::seconds(3);
  double landmark_share = 0.15;   ///< share of a registration's variance due to landmarks, [0, 1]
  double view_distance_m = 50.0;  ///< travelled while a landmark stays in view
  double max_view_time_s = 10.0;  ///< the longest time for which it does
};
std::span<const OptionField<RegistrationFactorOptions>> FieldsOf(
    const RegistrationFactorOptions& options);
absl::Status Validate(const RegistrationFactorOptions& options);

/// What determines how much successive registrations have in common.
struct RegistrationTiming {
  std::chrono::nanoseconds interval;     ///< since the last one
  std::chrono::nanoseconds submap_span;  ///< how long each scan stays in the sub-map
  double speed_mps;                      ///< decides how long landmarks stay in view
  int count;                             ///< of registrations so far
};

/// A registration's covariance, scaled by its residuals.
template <int Dim>
TangentMatrix<Dim> ResidualScaledCovariance(const Registration<Dim>& registration);

/// The absolute pose factor that a registration becomes (METHOD eq 31-33). `degeneracy` is the
/// covariance of what it does not observe, `noise` its own learned covariance, `systematic` that of
/// errors that do not average out (see AbsolutePoseFactor).
///
/// A scan takes part in every registration while it is in the sub-map, and a landmark while it is
/// in view. So a factor's information is divided among the registrations that share it. Its weight
/// assumes shared errors of the size and duration in the options. A share of the noise is the
/// landmarks', and lasts while the vehicle passes them.
template <int Dim>
AbsolutePoseFactor<Dim> RegistrationFactor(const Registration<Dim>& registration,
                                           const TangentMatrix<Dim>& degeneracy,
                                           const TangentMatrix<Dim>& noise,
                                           const TangentMatrix<Dim>& systematic,
                                           const RegistrationTiming& timing,
                                           const RegistrationFactorOptions& options);

}  // namespace dcloc
