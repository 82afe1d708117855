#include "client/evaluation/baselines/window_graph.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "core/geometry/covariance.h"

namespace dcloc {
namespace {

constexpr Eigen::Index kDof = 3;

struct NormalEquations {
  explicit NormalEquations(Eigen::Index size)
      : hessian(Eigen::MatrixXd::Zero(size, size)), gradient(Eigen::VectorXd::Zero(size)) {}
  Eigen::MatrixXd hessian;
  Eigen::VectorXd gradient;
};

Eigen::Matrix3d Information(const Eigen::Matrix3d& covariance) {
  constexpr double kMinVariance = 1e-10;  // what is known exactly would have an infinite weight
  return (covariance + kMinVariance * Eigen::Matrix3d::Identity()).inverse();
}

// Residual Log(Z^-1 T), whose derivative by a perturbation on the right of T is the identity to
// first order.
void AddUnary(const Pose2& pose, const PoseEstimate<2>& edge, Eigen::Index at,
              NormalEquations& normal) {
  const Eigen::Vector3d residual = Log(edge.pose.Inverse() * pose);
  const Eigen::Matrix3d information = Information(edge.covariance);
  normal.hessian.block<kDof, kDof>(at, at) += information;
  normal.gradient.segment<kDof>(at) += information * residual;
}

// Residual Log(Z^-1 T_from^-1 T_to).
void AddBinary(const Pose2& from, const Pose2& to, const PoseEstimate<2>& edge, Eigen::Index at,
               NormalEquations& normal) {
  const Pose2 T_from_to = from.Inverse() * to;
  const Eigen::Vector3d residual = Log(edge.pose.Inverse() * T_from_to);
  const Eigen::Matrix3d information = Information(edge.covariance);
  Eigen::Matrix<double, kDof, 2 * kDof> jacobian;
  jacobian << -Adjoint(T_from_to.Inverse()), Eigen::Matrix3d::Identity();
  normal.hessian.block<2 * kDof, 2 * kDof>(at, at) += jacobian.transpose() * information * jacobian;
  normal.gradient.segment<2 * kDof>(at) += jacobian.transpose() * (information * residual);
}

}  // namespace

void WindowGraph::Reset(const PoseEstimate<2>& first) {
  states_.clear();
  states_.push_back({.pose = first.pose, .loop = first});
  newest_ = first;
}

void WindowGraph::AddState(const PoseEstimate<2>& odometry) {
  states_.push_back({.pose = states_.back().pose * odometry.pose, .odometry = odometry});
  if (states_.size() > static_cast<std::size_t>(window_)) states_.pop_front();
  newest_ = {
      .pose = states_.back().pose,
      .covariance = ComposeCovariance<2>(newest_.covariance, odometry.pose, odometry.covariance)};
}

void WindowGraph::AddAbsolutePose(const PoseEstimate<2>& loop) { states_.back().loop = loop; }

void WindowGraph::Solve() {
  constexpr int kIterations = 5;
  // A window without a loop edge is held where it is: the paper forgets the states before it.
  if (std::ranges::none_of(states_, [](const State& state) { return state.loop.has_value(); })) {
    states_.front().loop = {.pose = states_.front().pose,
                            .covariance = Eigen::Matrix3d::Identity()};
  }
  const auto size = kDof * static_cast<Eigen::Index>(states_.size());
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    NormalEquations normal(size);
    for (std::size_t i = 0; i < states_.size(); ++i) {
      const Eigen::Index at = kDof * static_cast<Eigen::Index>(i);
      const State& state = states_[i];
      if (state.loop) AddUnary(state.pose, *state.loop, at, normal);
      if (i > 0) AddBinary(states_[i - 1].pose, state.pose, state.odometry, at - kDof, normal);
    }
    const Eigen::LDLT<Eigen::MatrixXd> factors(normal.hessian);
    const Eigen::VectorXd step = -factors.solve(normal.gradient);
    for (std::size_t i = 0; i < states_.size(); ++i) {
      const Eigen::Vector3d xi = step.segment<kDof>(kDof * static_cast<Eigen::Index>(i));
      states_[i].pose = states_[i].pose * Exp(xi);
    }
    const Eigen::MatrixXd newest = Eigen::MatrixXd::Identity(size, size).rightCols<kDof>();
    newest_ = {.pose = states_.back().pose, .covariance = factors.solve(newest).bottomRows<kDof>()};
  }
}

void WindowGraph::ChangeFrame(const Pose2& T_new_old) {
  for (State& state : states_) {
    state.pose = T_new_old * state.pose;
    if (state.loop) state.loop->pose = T_new_old * state.loop->pose;
  }
  newest_.pose = T_new_old * newest_.pose;
}

}  // namespace dcloc
