#pragma once

#include <Eigen/Core>
#include <span>

#include "core/geometry/pose.h"

namespace dcloc {

/// A place in two frames of the plane.
struct PlacePair {
  Eigen::Vector2d p_a_m = Eigen::Vector2d::Zero();
  Eigen::Vector2d p_b_m = Eigen::Vector2d::Zero();
};

/// T_a_b that brings the pairs together in the least squares sense, without a scale (Umeyama). With
/// one pair a shift, with none the identity.
Pose2 FitRigid(std::span<const PlacePair> pairs);

}  // namespace dcloc
