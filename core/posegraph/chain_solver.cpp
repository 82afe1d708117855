#include "core/posegraph/chain_solver.h"

#include <algorithm>
#include <cmath>

namespace dcloc {
namespace {

// An edge's difference (METHOD eq 16) with its derivatives by motions on the right of its two
// poses.
template <int Dim>
struct LinearDifference {
  Tangent<Dim> value;
  TangentMatrix<Dim> by_from = TangentMatrix<Dim>::Zero();
  TangentMatrix<Dim> by_to = TangentMatrix<Dim>::Zero();
};

LinearDifference<2> Difference(const Pose2& measured, const Pose2& from, const Pose2& to) {
  const Eigen::Matrix2d R_measured = measured.Rotation();
  const Eigen::Vector2d apart =
      from.Rotation().transpose() * (to.translation_m - from.translation_m);
  LinearDifference<2> difference;
  difference.value.head<2>() = R_measured.transpose() * (apart - measured.translation_m);
  difference.value(2) = WrapAngle(to.yaw_rad - from.yaw_rad - measured.yaw_rad);
  difference.by_to.topLeftCorner<2, 2>() =
      Eigen::Rotation2Dd(difference.value(2)).toRotationMatrix();
  difference.by_to(2, 2) = 1.0;
  difference.by_from.topLeftCorner<2, 2>() = -R_measured.transpose();
  difference.by_from.topRightCorner<2, 1>() =
      R_measured.transpose() * Eigen::Vector2d(apart.y(), -apart.x());
  difference.by_from(2, 2) = -1.0;
  return difference;
}

LinearDifference<3> Difference(const Pose3& measured, const Pose3& from, const Pose3& to) {
  const Eigen::Matrix3d R_measured = measured.Rotation();
  const Eigen::Vector3d apart =
      from.Rotation().transpose() * (to.translation_m - from.translation_m);
  const Eigen::Quaterniond turn =
      measured.rotation.conjugate() * (from.rotation.conjugate() * to.rotation);
  const double sign = turn.w() < 0.0 ? -1.0 : 1.0;
  const Eigen::Matrix3d turn_w = sign * turn.w() * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d turn_cross = sign * Skew(turn.vec());
  LinearDifference<3> difference;
  difference.value << R_measured.transpose() * (apart - measured.translation_m),
      2.0 * sign * turn.vec();
  difference.by_to.topLeftCorner<3, 3>() = turn.toRotationMatrix();
  difference.by_to.bottomRightCorner<3, 3>() = turn_w + turn_cross;
  difference.by_from.topLeftCorner<3, 3>() = -R_measured.transpose();
  difference.by_from.topRightCorner<3, 3>() = R_measured.transpose() * Skew(apart);
  difference.by_from.bottomRightCorner<3, 3>() = (turn_cross - turn_w) * R_measured.transpose();
  return difference;
}

}  // namespace

template <int Dim>
bool ChainSolver<Dim>::Solve(StateChain<Dim>& chain) {
  constexpr int kMaxSteps = 8;
  // Steps shrink a thousandfold each: what is left after one so small is far below a micrometre.
  constexpr double kSmallStep = 1e-7;
  Begin(chain);
  double first_cost = 0.0;
  for (int i = 0; i < kMaxSteps; ++i) {
    const double cost = Linearize();
    if (i == 0) first_cost = cost;
    SolveForSteps();
    double largest = 0.0;
    for (Row& row : rows_) {
      const double size = row.step.cwiseAbs().maxCoeff();
      if (!std::isfinite(size)) return false;
      largest = std::max(largest, size);
      row.pose = row.pose * Exp(row.step);
    }
    if (largest > kSmallStep) continue;
    constexpr double kRounding = 1e-9;
    if (cost > first_cost * (1.0 + kRounding) + kRounding) return false;
    for (std::size_t row = 0; row < rows_.size(); ++row) chain.states[row].pose = rows_[row].pose;
    return true;
  }
  return false;
}

template <int Dim>
typename ChainSolver<Dim>::Edge ChainSolver<Dim>::Weigh(const PoseEstimate<Dim>& measured) {
  return {.measured = measured.pose,
          .information = measured.covariance.llt().solve(TangentMatrix<Dim>::Identity())};
}

template <int Dim>
void ChainSolver<Dim>::Begin(const StateChain<Dim>& chain) {
  rows_.resize(chain.states.size());
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const typename StateChain<Dim>::State& state = chain.states[i];
    rows_[i].pose = state.pose;
    rows_[i].tie = Weigh(i == 0 ? chain.prior : state.odometry);
    rows_[i].absolute = state.absolute ? std::optional(Weigh(*state.absolute)) : std::nullopt;
  }
}

// The normal equations at the rows' poses; gives the cost there.
template <int Dim>
double ChainSolver<Dim>::Linearize() {  // METHOD eq 15-17
  double cost = 0.0;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    Row& row = rows_[i];
    row.diagonal.setZero();
    row.gradient.setZero();
    cost += i == 0 ? AddToMap(row.tie, row) : AddBetween(row.tie, rows_[i - 1], row);
    if (row.absolute) cost += AddToMap(*row.absolute, row);
  }
  return cost;
}

template <int Dim>
double ChainSolver<Dim>::AddToMap(const Edge& edge, Row& row) {
  const LinearDifference<Dim> difference = Difference(edge.measured, Pose<Dim>(), row.pose);
  const TangentMatrix<Dim> weighted = difference.by_to.transpose() * edge.information;
  row.diagonal += weighted * difference.by_to;
  row.gradient += weighted * difference.value;
  return difference.value.dot(edge.information * difference.value);
}

template <int Dim>
double ChainSolver<Dim>::AddBetween(const Edge& edge, Row& from, Row& to) {
  const LinearDifference<Dim> difference = Difference(edge.measured, from.pose, to.pose);
  const TangentMatrix<Dim> weighted_from = difference.by_from.transpose() * edge.information;
  const TangentMatrix<Dim> weighted_to = difference.by_to.transpose() * edge.information;
  from.diagonal += weighted_from * difference.by_from;
  from.gradient += weighted_from * difference.value;
  to.before = weighted_from * difference.by_to;
  to.diagonal += weighted_to * difference.by_to;
  to.gradient += weighted_to * difference.value;
  return difference.value.dot(edge.information * difference.value);
}

// Cholesky by blocks: each state is eliminated into the one after it, then they are solved for from
// the newest back.
template <int Dim>
void ChainSolver<Dim>::SolveForSteps() {
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    Row& row = rows_[i];
    if (i > 0) {
      const Row& previous = rows_[i - 1];
      const TangentMatrix<Dim> carried = previous.eliminated.solve(row.before);
      row.diagonal -= row.before.transpose() * carried;
      row.gradient -= carried.transpose() * previous.gradient;
    }
    row.eliminated.compute(row.diagonal);
  }
  for (std::size_t i = rows_.size(); i-- > 0;) {
    Row& row = rows_[i];
    Tangent<Dim> right = -row.gradient;
    if (i + 1 < rows_.size()) right -= rows_[i + 1].before * rows_[i + 1].step;
    row.step = row.eliminated.solve(right);
  }
}

template class ChainSolver<2>;
template class ChainSolver<3>;

}  // namespace dcloc
