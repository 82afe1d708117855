#include "core/posegraph/ceres_chain.h"

#include <ceres/ceres.h>

#include <vector>

#include "core/posegraph/edge_residual.h"

namespace dcloc {
namespace {

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
bool SolveByCeres(StateChain<Dim>& chain, double tolerance) {
  using Parameters = Eigen::Matrix<double, kParameters<Dim>, 1>;
  std::vector<Parameters> blocks;
  blocks.reserve(chain.states.size());

  ceres::Problem::Options problem_options;
  problem_options.disable_all_safety_checks = true;  // made here, once, of blocks that are all ours
  ceres::Problem problem(problem_options);
  for (const typename StateChain<Dim>::State& state : chain.states) {
    Parameters& block = blocks.emplace_back(ToParameters(state.pose));
    problem.AddParameterBlock(block.data(), kParameters<Dim>, MakeManifold<Dim>());
    const auto add_to_map = [&](const PoseEstimate<Dim>& edge) {
      problem.AddResidualBlock(EdgeResidual<Dim>::MakeFromMap(edge.pose, edge.covariance).release(),
                               nullptr, block.data());
    };
    if (blocks.size() == 1) {
      add_to_map(chain.prior);
    } else {
      problem.AddResidualBlock(
          EdgeResidual<Dim>::Make(state.odometry.pose, state.odometry.covariance).release(),
          nullptr, blocks[blocks.size() - 2].data(), block.data());
    }
    if (state.absolute) add_to_map(*state.absolute);
  }

  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 10;
  options.function_tolerance = tolerance;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable()) return false;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    chain.states[i].pose = FromParameters(blocks[i]);
  }
  return true;
}

template bool SolveByCeres<2>(StateChain<2>&, double);
template bool SolveByCeres<3>(StateChain<3>&, double);

}  // namespace dcloc
