#pragma once

#include <cmath>

#include "core/geometry/covariance.h"
#include "core/geometry/pose.h"
#include "core/localizer/localizer_options.h"
#include "core/odometry/motion.h"
#include "core/posegraph/state_chain.h"

namespace dcloc {

/// A pose in space and its covariance in the dimension of a pipeline.
template <int Dim>
PoseEstimate<Dim> FromSpace(const Pose3& pose, const Matrix6d& covariance) {
  if constexpr (Dim == 2) {
    return {.pose = Flatten(pose), .covariance = FlattenCovariance(covariance)};
  } else {
    return {.pose = pose, .covariance = covariance};
  }
}

/// Back into space; what the plane leaves open gets the options' deviations.
template <int Dim>
PoseEstimate<3> ToSpace(const PoseEstimate<Dim>& estimate, const LocalizerOptions& options) {
  if constexpr (Dim == 2) {
    return {.pose = Embed(estimate.pose),
            .covariance =
                EmbedCovariance(estimate.covariance, std::pow(options.unobserved_z_sigma_m, 2),
                                std::pow(options.unobserved_tilt_sigma_rad, 2))};
  } else {
    return estimate;
  }
}

/// The same of a motion.
template <int Dim>
PoseEstimate<Dim> ToEstimate(const Motion& motion) {
  return FromSpace<Dim>(motion.T_from_to, motion.covariance);
}

}  // namespace dcloc
