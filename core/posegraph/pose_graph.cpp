#include "core/posegraph/pose_graph.h"

#include <Eigen/Cholesky>

#include "core/geometry/covariance.h"
#include "core/posegraph/ceres_chain.h"

namespace dcloc {
namespace {

// What is known exactly (two scans of one moment, a start without degeneracy) would have an
// infinite weight.
constexpr double kMinVariance = 1e-10;

// The better of two views of one pose: A (A + B)^-1 is the share of the second.
template <int Dim>
TangentMatrix<Dim> Gain(const TangentMatrix<Dim>& first, const TangentMatrix<Dim>& second) {
  return TangentMatrix<Dim>(first + second).ldlt().solve(first).transpose();
}

template <int Dim>
TangentMatrix<Dim> UpdatedCovariance(const TangentMatrix<Dim>& first,
                                     const TangentMatrix<Dim>& second) {
  const TangentMatrix<Dim> keep = TangentMatrix<Dim>::Identity() - Gain<Dim>(first, second);
  const TangentMatrix<Dim> updated = keep * first;
  return 0.5 * (updated + updated.transpose());
}

template <int Dim>
PoseEstimate<Dim> Update(const PoseEstimate<Dim>& first, const PoseEstimate<Dim>& second) {
  const Tangent<Dim> apart = Log(first.pose.Inverse() * second.pose);
  return {.pose = first.pose *
                  Exp(Tangent<Dim>(Gain<Dim>(first.covariance, second.covariance) * apart)),
          .covariance = UpdatedCovariance<Dim>(first.covariance, second.covariance)};
}

}  // namespace

std::span<const OptionField<PoseGraphOptions>> FieldsOf(const PoseGraphOptions& /*options*/) {
  using O = PoseGraphOptions;
  static constexpr OptionField<O> kFields[] = {
      {"window", &O::window, 1, 1000},
      {"max_squared_distance_planar", &O::max_squared_distance_planar, 1e-6, 1e6},
      {"max_squared_distance_spatial", &O::max_squared_distance_spatial, 1e-6, 1e6},
      {"takeover_support", &O::takeover_support, 2, 1'000'000},
      {"near_squared_distance", &O::near_squared_distance, 0, 1e6, "no outlier is near"},
      {"near_takeover_support", &O::near_takeover_support, 2, 1'000'000},
  };
  return kFields;
}

absl::Status Validate(const PoseGraphOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

template <int Dim>
void PoseGraph<Dim>::Reset(const PoseEstimate<Dim>& prior, const TangentMatrix<Dim>& systematic) {
  chain_.prior = prior;
  chain_.prior.covariance.diagonal().array() += kMinVariance;
  chain_.states.clear();
  chain_.states.push_back({.pose = prior.pose,
                           .odometry = {},
                           .absolute = {},
                           .covariance = chain_.prior.covariance,
                           .noise_covariance = chain_.prior.covariance,
                           .systematic = systematic});
}

template <int Dim>
void PoseGraph<Dim>::AddState(const PoseEstimate<Dim>& odometry,
                              const TangentMatrix<Dim>& noise_covariance) {
  chain_.states.push_back(
      {.pose = chain_.states.back().pose * odometry.pose, .odometry = odometry});
  chain_.states.back().odometry.covariance.diagonal().array() += kMinVariance;
  chain_.states.back().covariance = NewestPredicted();
  chain_.states.back().noise_covariance = ComposeCovariance<Dim>(
      chain_.states[size() - 2].noise_covariance, odometry.pose, noise_covariance);
  chain_.states.back().systematic =
      Adjoint(odometry.pose.Inverse()) * chain_.states[size() - 2].systematic;
  if (size() > static_cast<std::size_t>(options_.window)) MarginalizeOldest();
}

template <int Dim>
InnovationTest PoseGraph<Dim>::AddAbsolutePose(const AbsolutePoseFactor<Dim>& factor) {
  State& newest = chain_.states.back();
  const Tangent<Dim> apart = Log(newest.pose.Inverse() * factor.pose);
  const TangentMatrix<Dim> spread = factor.covariance + newest.covariance;
  InnovationTest test;
  test.squared_distance = apart.dot(spread.ldlt().solve(apart));  // METHOD eq 19, 28
  const double limit =
      Dim == 2 ? options_.max_squared_distance_planar : options_.max_squared_distance_spatial;
  // Written so that a distance that is not a number fails.
  test.is_accepted = !options_.gate_outliers || test.squared_distance <= limit;
  if (test.is_accepted) {
    newest.absolute = {.pose = factor.pose, .covariance = factor.weight_covariance};
    const TangentMatrix<Dim> gain = Gain<Dim>(newest.covariance, factor.weight_covariance);
    const TangentMatrix<Dim> keep = TangentMatrix<Dim>::Identity() - gain;
    newest.noise_covariance =
        keep * newest.noise_covariance * keep.transpose() +
        gain * factor.noise_covariance.value_or(factor.weight_covariance) * gain.transpose();
    newest.systematic = keep * newest.systematic + gain * factor.systematic;
    newest.covariance = UpdatedCovariance<Dim>(NewestPredicted(), factor.weight_covariance);
  }
  return test;
}

template <int Dim>
void PoseGraph<Dim>::Solve() {
  // Where neither finds a solution, the filtered states stand.
  if (!solver_.Solve(chain_)) SolveByCeres(chain_);
}

template <int Dim>
PoseEstimate<Dim> PoseGraph<Dim>::Newest() const {
  return {.pose = chain_.states.back().pose, .covariance = chain_.states.back().covariance};
}

template <int Dim>
TangentMatrix<Dim> PoseGraph<Dim>::NewestNoiseCovariance() const {
  const State& newest = chain_.states.back();
  return newest.noise_covariance + newest.systematic * newest.systematic.transpose();
}

template <int Dim>
void PoseGraph<Dim>::ChangeFrame(const Pose<Dim>& T_new_old) {
  // Covariances live on the right of the poses and stay as they are.
  chain_.prior.pose = T_new_old * chain_.prior.pose;
  for (State& state : chain_.states) {
    state.pose = T_new_old * state.pose;
    if (state.absolute) state.absolute->pose = T_new_old * state.absolute->pose;
  }
}

// Without its own absolute pose factor. In a chain the newest state's marginal covariance is what a
// filter over the edges gives, so each state's is worked out once, from the one before.
template <int Dim>
TangentMatrix<Dim> PoseGraph<Dim>::NewestPredicted() const {
  if (size() == 1) return chain_.prior.covariance;
  const PoseEstimate<Dim>& odometry = chain_.states.back().odometry;
  return ComposeCovariance<Dim>(chain_.states[size() - 2].covariance, odometry.pose,
                                odometry.covariance);
}

template <int Dim>
void PoseGraph<Dim>::MarginalizeOldest() {
  const State& oldest = chain_.states.front();
  const PoseEstimate<Dim> known =
      oldest.absolute ? Update<Dim>(chain_.prior, *oldest.absolute) : chain_.prior;
  const PoseEstimate<Dim>& odometry = chain_.states[1].odometry;
  chain_.prior = {
      .pose = known.pose * odometry.pose,
      .covariance = ComposeCovariance<Dim>(known.covariance, odometry.pose, odometry.covariance)};
  chain_.states.erase(chain_.states.begin());
}

template class PoseGraph<2>;
template class PoseGraph<3>;

}  // namespace dcloc
