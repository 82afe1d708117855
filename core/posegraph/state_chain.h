#pragma once

#include <optional>
#include <vector>

#include "core/geometry/pose_estimate.h"

namespace dcloc {

/// States of one vehicle in a map frame, each tied to the one before (METHOD eq 15-17). What is
/// sought are the poses with the least sum of squared whitened residuals (see EdgeResidual).
template <int Dim>
struct StateChain {
  struct State {
    Pose<Dim> pose;
    PoseEstimate<Dim> odometry;  ///< from the state before; of the first it means nothing
    std::optional<PoseEstimate<Dim>> absolute;  ///< a registration; absent, or left out
    /// Of the pose, by all edges up to this state.
    TangentMatrix<Dim> covariance = TangentMatrix<Dim>::Zero();
    /// The same by what the edges vary rather than by what they weigh.
    TangentMatrix<Dim> noise_covariance = TangentMatrix<Dim>::Zero();
    /// What the errors that last make of the pose; times its own transpose their covariance.
    TangentMatrix<Dim> systematic = TangentMatrix<Dim>::Zero();
  };
  PoseEstimate<Dim> prior;    ///< on the first state
  std::vector<State> states;  ///< oldest first
};

}  // namespace dcloc
