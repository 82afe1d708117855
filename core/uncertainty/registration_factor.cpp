#include "core/uncertainty/registration_factor.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cstdint>

namespace dcloc {
namespace {

template <int Dim>
TangentMatrix<Dim> SharedErrors(const RegistrationFactorOptions& options) {
  Tangent<Dim> variances;
  variances.template head<Dim>().setConstant(options.shared_sigma_m * options.shared_sigma_m);
  variances.template tail<Pose<Dim>::kDof - Dim>().setConstant(options.shared_sigma_rad *
                                                               options.shared_sigma_rad);
  return variances.asDiagonal();
}

// L of L L^T.
template <int Dim>
TangentMatrix<Dim> SquareRoot(TangentMatrix<Dim> covariance) {
  constexpr double kMinVariance = 1e-12;
  covariance.diagonal().array() += kMinVariance;
  return covariance.llt().matrixL();
}

// METHOD eq 31: into how many registrations what lasts for `duration` is divided; no more than
// there were.
double SharingCount(std::chrono::nanoseconds duration, const RegistrationTiming& timing) {
  const double count =
      1.0 + static_cast<double>(duration.count()) /
                static_cast<double>(std::max<std::int64_t>(1, timing.interval.count()));
  return std::min<double>(count, timing.count);
}

// How long landmarks are seen.
std::chrono::nanoseconds TimeInView(double speed_mps, const RegistrationFactorOptions& options) {
  const double time_s =
      std::min(options.max_view_time_s, options.view_distance_m / std::max(1e-3, speed_mps));
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::duration<double>(time_s));
}

}  // namespace

std::span<const OptionField<RegistrationFactorOptions>> FieldsOf(
    const RegistrationFactorOptions& /*options*/) {
  using O = RegistrationFactorOptions;
  static constexpr OptionField<O> kFields[] = {
      {"shared_sigma_m", &O::shared_sigma_m, 0, 100, "registrations share no error"},
      {"shared_sigma_rad", &O::shared_sigma_rad, 0, 1, "registrations share no error"},
      {"shared_time_ms", &O::shared_time, 0, 1e6, "shared errors are new at each registration"},
      {"landmark_share", &O::landmark_share, 0, 1, "landmarks do not err"},
      {"view_distance_m", &O::view_distance_m, 0, 1e4, "landmarks are new at each registration"},
      {"max_view_time_s", &O::max_view_time_s, 0, 1e4, "landmarks are new at each registration"},
  };
  return kFields;
}

absl::Status Validate(const RegistrationFactorOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

template <int Dim>
TangentMatrix<Dim> ResidualScaledCovariance(const Registration<Dim>& registration) {
  return registration.residual_scale * registration.residual_scale * registration.covariance;
}

template <int Dim>
AbsolutePoseFactor<Dim> RegistrationFactor(const Registration<Dim>& registration,
                                           const TangentMatrix<Dim>& degeneracy,
                                           const TangentMatrix<Dim>& noise,
                                           const TangentMatrix<Dim>& systematic,
                                           const RegistrationTiming& timing,
                                           const RegistrationFactorOptions& options) {
  // What was left over beyond the model widens the covariance; what agreed better does not narrow
  // it.
  const double scale = std::max(1.0, registration.residual_scale);
  const TangentMatrix<Dim> own = scale * scale * registration.covariance + degeneracy;
  const TangentMatrix<Dim> shared = SharedErrors<Dim>(options);
  const double by_scans = SharingCount(timing.submap_span, timing);
  const double by_view =
      options.landmark_share * SharingCount(TimeInView(timing.speed_mps, options), timing);
  return {.pose = registration.T_local_vehicle,
          .covariance = own + shared,
          .weight_covariance = by_scans * own + SharingCount(options.shared_time, timing) * shared,
          .noise_covariance = (by_scans + by_view) * noise + degeneracy,
          .systematic = SquareRoot<Dim>(systematic)};
}

template TangentMatrix<2> ResidualScaledCovariance(const Registration<2>&);
template TangentMatrix<3> ResidualScaledCovariance(const Registration<3>&);
template AbsolutePoseFactor<2> RegistrationFactor(const Registration<2>&, const TangentMatrix<2>&,
                                                  const TangentMatrix<2>&, const TangentMatrix<2>&,
                                                  const RegistrationTiming&,
                                                  const RegistrationFactorOptions&);
template AbsolutePoseFactor<3> RegistrationFactor(const Registration<3>&, const TangentMatrix<3>&,
                                                  const TangentMatrix<3>&, const TangentMatrix<3>&,
                                                  const RegistrationTiming&,
                                                  const RegistrationFactorOptions&);

}  // namespace dcloc
