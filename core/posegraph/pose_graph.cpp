#include "core/posegraph/pose_graph.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <vector>

#include "core/geometry/covariance.h"
#include "core/posegraph/edge_residual.h"

namespace dcloc {
namespace {

// What is known exactly (two scans of one moment, a start without doubt) would have an infinite
// weight.
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

// nullptr where the parameters are a vector space.
template <int Dim>
ceres::Manifold* MakeManifold() {
  if constexpr (Dim == 2) {
    return nullptr;
  } else {
    return new ceres::ProductManifold<ceres::EuclideanManifold<3>,
                                      ceres::EigenQuaternionManifold>();
  }
}

}  // namespace

template <int Dim>
void PoseGraph<Dim>::Reset(const PoseEstimate<Dim>& prior) {
  prior_ = prior;
  prior_.covariance.diagonal().array() += kMinVariance;
  states_.clear();
  states_.push_back({.pose = prior.pose});
}

template <int Dim>
void PoseGraph<Dim>::AddState(const PoseEstimate<Dim>& odometry) {
  states_.push_back({.pose = states_.back().pose * odometry.pose, .odometry = odometry});
  states_.back().odometry.covariance.diagonal().array() += kMinVariance;
  if (states_.size() > static_cast<std::size_t>(options_.window)) MarginalizeOldest();
}

template <int Dim>
EdgeTest PoseGraph<Dim>::AddLoop(const LoopEdge<Dim>& loop) {
  State& newest = states_.back();
  const Tangent<Dim> apart = Log(newest.pose.Inverse() * loop.pose);
  const TangentMatrix<Dim> spread = loop.covariance + FilteredCovariance();
  EdgeTest test;
  test.distance = apart.dot(spread.ldlt().solve(apart));
  const double limit = Dim == 2 ? options_.max_distance_planar : options_.max_distance_spatial;
  // Written so that a distance that is not a number fails.
  test.valid = !options_.truncate || test.distance <= limit;
  if (test.valid) newest.loop = {.pose = loop.pose, .covariance = loop.reused_covariance};
  return test;
}

template <int Dim>
void PoseGraph<Dim>::Solve() {
  using Parameters = Eigen::Matrix<double, kParameters<Dim>, 1>;
  std::vector<Parameters> blocks;
  blocks.reserve(states_.size());

  ceres::Problem::Options problem_options;
  problem_options.disable_all_safety_checks = true;  // made here, once, of blocks that are all ours
  ceres::Problem problem(problem_options);
  for (const State& state : states_) {
    Parameters& block = blocks.emplace_back(ToParameters(state.pose));
    problem.AddParameterBlock(block.data(), kParameters<Dim>, MakeManifold<Dim>());
    const auto add_to_map = [&](const PoseEstimate<Dim>& edge) {
      problem.AddResidualBlock(EdgeResidual<Dim>::MakeFromMap(edge.pose, edge.covariance).release(),
                               nullptr, block.data());
    };
    if (blocks.size() == 1) {
      add_to_map(prior_);
    } else {
      problem.AddResidualBlock(
          EdgeResidual<Dim>::Make(state.odometry.pose, state.odometry.covariance).release(),
          nullptr, blocks[blocks.size() - 2].data(), block.data());
    }
    if (state.loop) add_to_map(*state.loop);
  }

  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 10;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable()) return;  // the filtered states stand
  for (std::size_t i = 0; i < states_.size(); ++i) states_[i].pose = FromParameters(blocks[i]);
}

template <int Dim>
PoseEstimate<Dim> PoseGraph<Dim>::Newest() const {
  return {.pose = states_.back().pose, .covariance = FilteredCovariance()};
}

template <int Dim>
void PoseGraph<Dim>::ChangeFrame(const Pose<Dim>& T_new_old) {
  // Covariances live on the right of the poses and stay as they are.
  prior_.pose = T_new_old * prior_.pose;
  for (State& state : states_) {
    state.pose = T_new_old * state.pose;
    if (state.loop) state.loop->pose = T_new_old * state.loop->pose;
  }
}

// In a chain the newest state's marginal covariance is what a filter over the edges gives.
template <int Dim>
TangentMatrix<Dim> PoseGraph<Dim>::FilteredCovariance() const {
  TangentMatrix<Dim> covariance = prior_.covariance;
  for (std::size_t i = 0; i < states_.size(); ++i) {
    const State& state = states_[i];
    if (i > 0) {
      covariance =
          ComposeCovariance<Dim>(covariance, state.odometry.pose, state.odometry.covariance);
    }
    if (state.loop) covariance = UpdatedCovariance<Dim>(covariance, state.loop->covariance);
  }
  return covariance;
}

template <int Dim>
void PoseGraph<Dim>::MarginalizeOldest() {
  const State& oldest = states_.front();
  const PoseEstimate<Dim> known = oldest.loop ? Update<Dim>(prior_, *oldest.loop) : prior_;
  const PoseEstimate<Dim>& odometry = states_[1].odometry;
  prior_ = {
      .pose = known.pose * odometry.pose,
      .covariance = ComposeCovariance<Dim>(known.covariance, odometry.pose, odometry.covariance)};
  states_.pop_front();
}

template class PoseGraph<2>;
template class PoseGraph<3>;

}  // namespace dcloc
