#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "absl/status/status.h"
#include "core/geometry/chi_square.h"
#include "core/options/option_fields.h"
#include "core/posegraph/chain_solver.h"
#include "core/posegraph/state_chain.h"

namespace dcloc {

/// The newest state's pose in the map frame by a registration: the paper's loop edge (METHOD eq
/// 15).
template <int Dim>
struct AbsolutePoseFactor {
  Pose<Dim> pose;
  TangentMatrix<Dim> covariance;  ///< of this registration alone; what the test uses
  /// The weight covariance that the solution uses. It is larger than `covariance`, as neighbouring
  /// registrations share measurements and errors.
  TangentMatrix<Dim> weight_covariance;
  /// The noise covariance: by what the registration really varies. Absent: `weight_covariance`.
  std::optional<TangentMatrix<Dim>> noise_covariance;
  /// A square root L of the covariance L L^T of the systematic errors that all factors share, by
  /// what is not known of mounts and clocks: each column is one such error's.
  TangentMatrix<Dim> systematic = TangentMatrix<Dim>::Zero();
};

struct PoseGraphOptions {
  int window = 10;  ///< states that are solved for, [1, 1000]
  /// Factors that fail the chi-square test against the fused state are left out (METHOD 7).
  bool gate_outliers = true;
  double max_squared_distance_planar = kChiSquare95With3Dof;
  double max_squared_distance_spatial = kChiSquare95With6Dof;
  /// Factors left out in a row that agree among themselves and so replace the accepted chain, >= 2.
  int takeover_support = 25;
  /// Squared Mahalanobis distance up to which the first of them is near the accepted chain: such an
  /// estimate has drifted a little, and the registrations are right.
  double near_squared_distance = 50.0;
  int near_takeover_support = 5;  ///< the same as `takeover_support` if the first was near
};
std::span<const OptionField<PoseGraphOptions>> FieldsOf(const PoseGraphOptions& options);
absl::Status Validate(const PoseGraphOptions& options);

/// What the test of an absolute pose factor gave (METHOD eq 19, on the fused state).
struct InnovationTest {
  double squared_distance = 0.0;  ///< Mahalanobis, to the predicted state
  bool is_accepted = false;
};

/// The last states of one vehicle in a map frame: odometry edges between neighbours, absolute
/// pose factors, and what older states knew as a prior on the oldest (METHOD eq 15-19). The chain
/// is solved by Gauss-Newton, and by Ceres where that does not get there; older states are
/// marginalized into the prior. In the steady state it allocates nothing.
template <int Dim>
class PoseGraph {
 public:
  explicit PoseGraph(const PoseGraphOptions& options = {}) : options_(options) {}

  /// Forgets everything and starts with one state. `systematic` is that of the factor that it comes
  /// of, if it does.
  void Reset(const PoseEstimate<Dim>& prior,
             const TangentMatrix<Dim>& systematic = TangentMatrix<Dim>::Zero());

  /// Adds a state that odometry leads to from the newest one: T_newest_new. Needs a state.
  void AddState(const PoseEstimate<Dim>& odometry) { AddState(odometry, odometry.covariance); }

  /// The same with the odometry's noise covariance beside its weight covariance.
  void AddState(const PoseEstimate<Dim>& odometry, const TangentMatrix<Dim>& noise_covariance);

  /// Gives the newest state an absolute pose factor and tests it against the fused prediction
  /// (METHOD eq 18-19); one that fails is left out, and odometry alone holds the state.
  InnovationTest AddAbsolutePose(const AbsolutePoseFactor<Dim>& factor);

  /// Solves for all states of the window.
  void Solve();

  /// The newest state with all that is known of it.
  PoseEstimate<Dim> Newest() const;

  /// The newest state's covariance by what the edges vary: the weights' gains K with the noises N,
  /// P = (I - K) P (I - K)^T + K N K^T, and with what lasts, B = (I - K) B + K L: P + B B^T.
  TangentMatrix<Dim> NewestNoiseCovariance() const;

  /// Expresses everything in another map frame.
  void ChangeFrame(const Pose<Dim>& T_new_old);

  bool empty() const { return chain_.states.empty(); }
  std::size_t size() const { return chain_.states.size(); }

 private:
  using State = typename StateChain<Dim>::State;

  TangentMatrix<Dim> NewestPredicted() const;
  void MarginalizeOldest();

  PoseGraphOptions options_;
  StateChain<Dim> chain_;
  ChainSolver<Dim> solver_;
};

}  // namespace dcloc
