#pragma once

#include <cmath>
#include <span>

#include "absl/status/status.h"
#include "core/geometry/covariance.h"
#include "core/geometry/pose.h"
#include "core/options/option_fields.h"

namespace dcloc {

/// Variance of a coordinate of which nothing is known [m^2, rad^2]: a deviation of 10 km or 10^4
/// rad, wider than any map and any turn, and still far from where 6 x 6 inverses lose digits.
inline constexpr double kUnknownVariance = 1e8;

/// A pose with its covariance in the tangent space on its right.
template <int Dim>
struct PoseEstimate {
  Pose<Dim> pose;
  TangentMatrix<Dim> covariance = TangentMatrix<Dim>::Zero();
};

/// Deviations of z, roll and pitch, which a planar rig does not observe and takes from the map's
/// keyframes.
struct UnobservedSigmas {
  double z_m = 0.5;
  double tilt_rad = 0.03;  ///< roll and pitch
};
std::span<const OptionField<UnobservedSigmas>> FieldsOf(const UnobservedSigmas& options);
absl::Status Validate(const UnobservedSigmas& options);

/// Converts a pose in space and its covariance to the dimension of a pipeline.
template <int Dim>
PoseEstimate<Dim> FromSpace(const Pose3& pose, const Matrix6d& covariance) {
  if constexpr (Dim == 2) {
    return {.pose = Flatten(pose), .covariance = FlattenCovariance(covariance)};
  } else {
    return {.pose = pose, .covariance = covariance};
  }
}

/// The inverse; z, roll and pitch of a planar pose get the deviations of `unobserved`.
template <int Dim>
PoseEstimate<3> ToSpace(const PoseEstimate<Dim>& estimate, const UnobservedSigmas& unobserved) {
  if constexpr (Dim == 2) {
    return {.pose = Embed(estimate.pose),
            .covariance = EmbedCovariance(estimate.covariance, std::pow(unobserved.z_m, 2),
                                          std::pow(unobserved.tilt_rad, 2))};
  } else {
    return estimate;
  }
}

}  // namespace dcloc
