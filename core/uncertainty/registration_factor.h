#pragma once

#include <chrono>
#include <span>

#include "absl/status/status.h"
#include "core/options/option_fields.h"
#include "core/posegraph/pose_graph.h"
#include "core/registration/gicp.h"

namespace dcloc {

/// What every registration lacks however many points agree: errors that its points share, of the
/// map, of mounts and of clocks. They keep their value for `shared_time`, so that more
/// registrations within it do not average them out.
struct RegistrationFactorOptions {
  double shared_sigma_m = 0.08;
  double shared_sigma_rad = 0.003;
  std::chrono::nanoseconds shared_time = std::chrono::seconds(3);
  /// Of what registrations vary by, so much is the landmarks', which are seen for so much way, but
  /// no longer than so.
  double landmark_share = 0.15;
  double view_distance_m = 50.0;
  double max_view_time_s = 10.0;
};
std::span<const OptionField<RegistrationFactorOptions>> FieldsOf(
    const RegistrationFactorOptions& options);
absl::Status Validate(const RegistrationFactorOptions& options);

/// What registrations that follow one another have in common.
struct RegistrationTiming {
  std::chrono::nanoseconds interval;     ///< since the last one
  std::chrono::nanoseconds submap_span;  ///< each scan is in the sub-map for so long
  double speed_mps;                      ///< landmarks stay in view for a way
  int count;                             ///< of registrations so far
};

/// A registration's covariance scaled to the residuals that it left.
template <int Dim>
TangentMatrix<Dim> ResidualScaledCovariance(const Registration<Dim>& registration);

/// The absolute pose factor that a registration becomes (METHOD eq 31-33). `degeneracy` is the
/// covariance of what it does not observe, `noise` its own learned covariance, `systematic` that of
/// errors that do not average out (see AbsolutePoseFactor).
///
/// Each scan's points take part in every registration while the scan is in the sub-map, and the
/// landmarks while they are in view. So a factor's information is divided among those that share
/// it. The weight assumes shared errors as large and lasting as the options say; of the noise a
/// part is the landmarks', while the vehicle passes them.
template <int Dim>
AbsolutePoseFactor<Dim> RegistrationFactor(const Registration<Dim>& registration,
                                           const TangentMatrix<Dim>& degeneracy,
                                           const TangentMatrix<Dim>& noise,
                                           const TangentMatrix<Dim>& systematic,
                                           const RegistrationTiming& timing,
                                           const RegistrationFactorOptions& options);

}  // namespace dcloc
