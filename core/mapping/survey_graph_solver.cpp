#include "core/mapping/survey_graph_solver.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include "absl/strings/str_cat.h"
#include "core/posegraph/edge_residual.h"

namespace dcloc {
namespace {

// The rounds end when no weight changes by more than this, and each is all or nothing to within a
// tenth.
constexpr double kSettledWeight = 1e-3;
constexpr double kNearlyHard = 10.0;

// A vehicle's position from a node's pose, whitened.
struct FixResidual {
  NodeFix fix;

  template <typename T>
  bool operator()(const T* node, T* residual) const {
    const T c = ceres::cos(node[2]);
    const T s = ceres::sin(node[2]);
    residual[0] = (node[0] + c * fix.p_node.x() - s * fix.p_node.y() - fix.p_map.x()) / fix.sigma_m;
    residual[1] = (node[1] + s * fix.p_node.x() + c * fix.p_node.y() - fix.p_map.y()) / fix.sigma_m;
    return true;
  }
};

double SquaredDistance(const NodeFix& fix, std::span<const Pose2> T_map_nodes) {
  return (T_map_nodes[fix.node] * fix.p_node - fix.p_map).squaredNorm() /
         (fix.sigma_m * fix.sigma_m);
}

// The surrogate cost of truncated least squares, for what may be wrong.
class TruncatedCost {
 public:
  explicit TruncatedCost(double max_squared_distance)
      : max_squared_distance_(max_squared_distance) {}

  // The weight of a measurement at a squared distance, for the control parameter mu.
  double Weight(double squared_distance, double mu) const {
    const double ratio = squared_distance / max_squared_distance_;
    if (ratio <= mu / (mu + 1.0)) return 1.0;
    if (ratio >= (mu + 1.0) / mu) return 0.0;
    return std::sqrt(mu * (mu + 1.0) / ratio) - mu;
  }

  // At which the surrogate is convex for a measurement at that distance.
  double ConvexMu(double squared_distance) const {
    const double excess = 2.0 * squared_distance / max_squared_distance_ - 1.0;
    return excess <= 0.0 ? 1e6 : 1.0 / excess;
  }

 private:
  double max_squared_distance_;
};

// The first node of each part of the graph that has no fix.
std::vector<std::size_t> NodesToHold(std::size_t node_count, std::span<const SurveyEdge> edges,
                                     std::span<const NodeFix> fixes) {
  const std::vector<std::size_t> part_of = PartsOf(node_count, edges);
  std::vector<bool> has_fix(node_count, false);
  for (const NodeFix& fix : fixes) has_fix[part_of[fix.node]] = true;
  std::vector<std::size_t> held;
  for (std::size_t node = 0; node < node_count; ++node) {
    if (part_of[node] == node && !has_fix[node]) held.push_back(node);
  }
  return held;
}

class Solver {
 public:
  Solver(std::span<const Pose2> T_map_nodes, std::span<const SurveyEdge> edges,
         std::span<const NodeFix> fixes, const SurveyGraphSolverOptions& options)
      : edges_(edges), fixes_(fixes), options_(options), problem_(ProblemOptions()) {
    blocks_.reserve(T_map_nodes.size());
    for (const Pose2& T : T_map_nodes) blocks_.push_back(ToParameters(T));
    for (Eigen::Vector3d& block : blocks_) problem_.AddParameterBlock(block.data(), 3);
    for (const std::size_t node : NodesToHold(T_map_nodes.size(), edges, fixes)) {
      problem_.SetParameterBlockConstant(blocks_[node].data());
    }
    for (const SurveyEdge& edge : edges) {
      edge_losses_.push_back(
          std::make_unique<ceres::LossFunctionWrapper>(nullptr, ceres::TAKE_OWNERSHIP));
      problem_.AddResidualBlock(
          EdgeResidual<2>::Make(edge.T_from_to.pose, edge.T_from_to.covariance).release(),
          edge_losses_.back().get(), blocks_[edge.from].data(), blocks_[edge.to].data());
    }
    for (const NodeFix& fix : fixes) {
      fix_losses_.push_back(
          std::make_unique<ceres::LossFunctionWrapper>(nullptr, ceres::TAKE_OWNERSHIP));
      problem_.AddResidualBlock(
          new ceres::AutoDiffCostFunction<FixResidual, 2, 3>(new FixResidual{fix}),
          fix_losses_.back().get(), blocks_[fix.node].data());
    }
  }

  std::vector<Pose2> Poses() const {
    std::vector<Pose2> poses;
    poses.reserve(blocks_.size());
    for (const Eigen::Vector3d& block : blocks_) poses.push_back(FromParameters(block));
    return poses;
  }

  absl::Status Solve(const std::vector<double>& edge_weights,
                     const std::vector<double>& fix_weights) {
    SetWeights(edge_weights, edge_losses_);
    SetWeights(fix_weights, fix_losses_);
    ceres::Solver::Options solver;
    solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    solver.max_num_iterations = options_.max_iterations;
    solver.function_tolerance = 1e-7;
    solver.logging_type = ceres::SILENT;
    solver.num_threads = 1;
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem_, &summary);
    if (summary.IsSolutionUsable()) return absl::OkStatus();
    return absl::FailedPreconditionError(
        absl::StrCat("the pose graph has no solution: ", summary.message));
  }

 private:
  static ceres::Problem::Options ProblemOptions() {
    ceres::Problem::Options options;
    options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    return options;
  }

  static void SetWeights(const std::vector<double>& weights,
                         std::vector<std::unique_ptr<ceres::LossFunctionWrapper>>& losses) {
    for (std::size_t i = 0; i < losses.size(); ++i) {
      losses[i]->Reset(new ceres::ScaledLoss(nullptr, weights[i], ceres::TAKE_OWNERSHIP),
                       ceres::TAKE_OWNERSHIP);
    }
  }

  std::span<const SurveyEdge> edges_;
  std::span<const NodeFix> fixes_;
  const SurveyGraphSolverOptions& options_;
  std::vector<Eigen::Vector3d> blocks_;
  std::vector<std::unique_ptr<ceres::LossFunctionWrapper>> edge_losses_;
  std::vector<std::unique_ptr<ceres::LossFunctionWrapper>> fix_losses_;
  ceres::Problem problem_;
};

// Sets the weights for poses; the largest change of one.
template <typename Measurement, typename WeightOf>
double Reweigh(std::span<const Measurement> measurements, const WeightOf& weight_of,
               std::vector<double>& weights) {
  double change = 0.0;
  for (std::size_t i = 0; i < measurements.size(); ++i) {
    const double weight = weight_of(measurements[i]);
    change = std::max(change, std::abs(weight - weights[i]));
    weights[i] = weight;
  }
  return change;
}

}  // namespace

std::span<const OptionField<SurveyGraphSolverOptions>> FieldsOf(
    const SurveyGraphSolverOptions& /*options*/) {
  using O = SurveyGraphSolverOptions;
  static constexpr OptionField<O> kFields[] = {
      {"max_squared_edge_distance", &O::max_squared_edge_distance, 0.1, 1e6},
      {"max_squared_fix_distance", &O::max_squared_fix_distance, 0.1, 1e6},
      {"growth", &O::growth, 1.05, 10},
      {"max_round_count", &O::max_round_count, 1, 1000},
      {"max_iterations", &O::max_iterations, 1, 1000},
  };
  return kFields;
}

absl::Status Validate(const SurveyGraphSolverOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

std::vector<std::size_t> PartsOf(std::size_t node_count, std::span<const SurveyEdge> edges) {
  std::vector<std::size_t> part_of(node_count);
  std::iota(part_of.begin(), part_of.end(), std::size_t{0});
  const auto first_of = [&](std::size_t node) {
    while (part_of[node] != node) node = part_of[node] = part_of[part_of[node]];
    return node;
  };
  for (const SurveyEdge& edge : edges) {
    const std::size_t a = first_of(edge.from);
    const std::size_t b = first_of(edge.to);
    part_of[std::max(a, b)] = std::min(a, b);
  }
  for (std::size_t node = 0; node < node_count; ++node) part_of[node] = first_of(node);
  return part_of;
}

double SquaredDistance(const SurveyEdge& edge, std::span<const Pose2> T_map_nodes) {
  const Pose2 difference =
      edge.T_from_to.pose.Inverse() * T_map_nodes[edge.from].Inverse() * T_map_nodes[edge.to];
  Eigen::Vector3d error;
  error << difference.translation_m, WrapAngle(difference.yaw_rad);
  return error.dot(edge.T_from_to.covariance.ldlt().solve(error));
}

namespace {

// The control parameter at which the surrogate is convex for all measurements.
double ConvexMu(std::span<const SurveyEdge> edges, const TruncatedCost& edge_cost,
                std::span<const NodeFix> fixes, const TruncatedCost& fix_cost,
                std::span<const Pose2> T_map_nodes) {
  double mu = 1e6;
  for (const SurveyEdge& edge : edges) {
    if (edge.is_certain) continue;
    mu = std::min(mu, edge_cost.ConvexMu(SquaredDistance(edge, T_map_nodes)));
  }
  for (const NodeFix& fix : fixes) {
    mu = std::min(mu, fix_cost.ConvexMu(SquaredDistance(fix, T_map_nodes)));
  }
  return mu;
}

}  // namespace

absl::StatusOr<SurveyGraphSolution> SolveSurveyGraph(std::span<const Pose2> T_map_nodes,
                                                     std::span<const SurveyEdge> edges,
                                                     std::span<const NodeFix> fixes,
                                                     const SurveyGraphSolverOptions& options) {
  SurveyGraphSolution solution{.T_map_nodes = {},
                               .edge_weights = std::vector<double>(edges.size(), 1.0),
                               .fix_weights = std::vector<double>(fixes.size(), 1.0)};
  const TruncatedCost edge_cost(options.max_squared_edge_distance);
  const TruncatedCost fix_cost(options.max_squared_fix_distance);
  Solver solver(T_map_nodes, edges, fixes, options);
  if (absl::Status status = solver.Solve(solution.edge_weights, solution.fix_weights);
      !status.ok()) {
    return status;
  }
  solution.T_map_nodes = solver.Poses();
  double mu = ConvexMu(edges, edge_cost, fixes, fix_cost, solution.T_map_nodes);
  for (int round = 0; round < options.max_round_count; ++round) {
    const double change = std::max(
        Reweigh(
            edges,
            [&](const SurveyEdge& edge) {
              return edge.is_certain
                         ? 1.0
                         : edge_cost.Weight(SquaredDistance(edge, solution.T_map_nodes), mu);
            },
            solution.edge_weights),
        Reweigh(
            fixes,
            [&](const NodeFix& fix) {
              return fix_cost.Weight(SquaredDistance(fix, solution.T_map_nodes), mu);
            },
            solution.fix_weights));
    if (change < kSettledWeight && mu > kNearlyHard) break;
    if (absl::Status status = solver.Solve(solution.edge_weights, solution.fix_weights);
        !status.ok()) {
      return status;
    }
    solution.T_map_nodes = solver.Poses();
    mu *= options.growth;
  }
  return solution;
}

}  // namespace dcloc
