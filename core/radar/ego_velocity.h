#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/geometry/pose.h"

namespace dcloc {

/// Velocity of the vehicle frame's origin and its turn rate, both in the vehicle frame.
struct EgoVelocity {
  Eigen::Vector3d linear_mps = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_radps = Eigen::Vector3d::Zero();
  /// Of (linear, angular); absent when the source does not know it.
  std::optional<Matrix6d> covariance;
};

}  // namespace dcloc
