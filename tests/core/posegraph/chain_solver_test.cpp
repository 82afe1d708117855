#include "core/posegraph/chain_solver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <type_traits>

#include "core/posegraph/ceres_chain.h"
#include "core/posegraph/edge_residual.h"
#include "tests/core/posegraph/chain.h"

namespace dcloc {
namespace {

template <typename Dimension>
class ChainSolverTest : public ::testing::Test {};

using Dimensions = ::testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(ChainSolverTest, Dimensions);

// As a tracker has it: states as odometry leads to them, and an absolute pose for three in four of
// them.
template <int Dim>
StateChain<Dim> ChainOf(const Chain<Dim>& drive) {
  StateChain<Dim> chain{.prior = drive.prior, .states = {{.pose = drive.prior.pose}}};
  for (std::size_t i = 0; i < drive.steps.size(); ++i) {
    const auto& step = drive.steps[i];
    chain.states.push_back(
        {.pose = chain.states.back().pose * step.odometry.pose, .odometry = step.odometry});
    if (i % 4 == 3) continue;
    chain.states.back().absolute = {.pose = step.factor.pose,
                                    .covariance = step.factor.weight_covariance};
  }
  return chain;
}

template <int Dim>
double Cost(const StateChain<Dim>& chain) {
  double cost = 0.0;
  const auto add = [&](const PoseEstimate<Dim>& edge, const Pose<Dim>& from, const Pose<Dim>& to) {
    Tangent<Dim> residual;
    const EdgeResidual<Dim> of_edge(edge.pose, edge.covariance);
    of_edge(ToParameters(from).data(), ToParameters(to).data(), residual.data());
    cost += residual.squaredNorm();
  };
  add(chain.prior, {}, chain.states.front().pose);
  for (std::size_t i = 0; i < chain.states.size(); ++i) {
    const auto& state = chain.states[i];
    if (i > 0) add(state.odometry, chain.states[i - 1].pose, state.pose);
    if (state.absolute) add(*state.absolute, {}, state.pose);
  }
  return cost;
}

template <int Dim>
double FurthestApart(const StateChain<Dim>& a, const StateChain<Dim>& b) {
  double furthest = 0.0;
  for (std::size_t i = 0; i < a.states.size(); ++i) {
    furthest = std::max(furthest,
                        Log(a.states[i].pose.Inverse() * b.states[i].pose).cwiseAbs().maxCoeff());
  }
  return furthest;
}

TYPED_TEST(ChainSolverTest, FindsTheMinimumThatCeresFinds) {
  constexpr int kDim = TypeParam::value;
  ChainSolver<kDim> solver;  // one for all: what is left in it must not matter
  for (const int count : {0, 1, 9, 60, 5}) {
    for (unsigned seed = 1; seed <= 20; ++seed) {
      const Chain<kDim> drive(count, Diagonal<kDim>(0.05, 0.01), Diagonal<kDim>(0.2, 0.02), seed);
      StateChain<kDim> ours = ChainOf(drive);
      StateChain<kDim> ceres = ours;
      ASSERT_TRUE(solver.Solve(ours)) << count << " states, seed " << seed;
      // At its usual tolerance it stops up to a tenth of a millimetre short of the minimum.
      ASSERT_TRUE(SolveByCeres(ceres, 1e-15));
      EXPECT_LE(Cost(ours), Cost(ceres) * (1.0 + 1e-9));
      EXPECT_LT(FurthestApart(ours, ceres), 1e-5);
    }
  }
}

TYPED_TEST(ChainSolverTest, NoNeighbouringPosesCostLess) {
  constexpr int kDim = TypeParam::value;
  const Chain<kDim> drive(6, Diagonal<kDim>(0.05, 0.01), Diagonal<kDim>(0.2, 0.02), 3);
  StateChain<kDim> chain = ChainOf(drive);
  ASSERT_TRUE(ChainSolver<kDim>().Solve(chain));
  const double least = Cost(chain);
  for (std::size_t i = 0; i < chain.states.size(); ++i) {
    for (int axis = 0; axis < Pose<kDim>::kDof; ++axis) {
      for (const double shift : {-1e-5, 1e-5}) {
        StateChain<kDim> beside = chain;
        beside.states[i].pose =
            beside.states[i].pose * Exp(Tangent<kDim>(shift * Tangent<kDim>::Unit(axis)));
        EXPECT_GT(Cost(beside), least) << "state " << i << ", axis " << axis;
      }
    }
  }
}

TYPED_TEST(ChainSolverTest, LeavesWhatIsTooFarOffToAnother) {
  constexpr int kDim = TypeParam::value;
  const Chain<kDim> drive(9, Diagonal<kDim>(0.05, 0.01), Diagonal<kDim>(0.2, 0.02), 4);
  StateChain<kDim> right = ChainOf(drive);
  StateChain<kDim> chain = right;
  ASSERT_TRUE(ChainSolver<kDim>().Solve(right));
  // Every second state turned by most of a half circle and ten metres away.
  for (std::size_t i = 1; i < chain.states.size(); i += 2) {
    Tangent<kDim> off = 10.0 * Tangent<kDim>::Unit(0);
    off(Pose<kDim>::kDof - 1) = 2.5;
    chain.states[i].pose = chain.states[i].pose * Exp(off);
  }
  const StateChain<kDim> before = chain;
  // In the plane it gets there from anywhere; in space it must say that it does not.
  const bool solved = ChainSolver<kDim>().Solve(chain);
  EXPECT_EQ(solved, kDim == 2);
  EXPECT_LT(FurthestApart(chain, solved ? right : before), 1e-6);
  EXPECT_TRUE(SolveByCeres(chain));
  EXPECT_LT(Cost(chain), 0.1 * Cost(before));
}

TYPED_TEST(ChainSolverTest, WhatIsNoNumberIsRefused) {
  constexpr int kDim = TypeParam::value;
  const Chain<kDim> drive(5, Diagonal<kDim>(0.05, 0.01), Diagonal<kDim>(0.2, 0.02), 5);
  const StateChain<kDim> good = ChainOf(drive);
  StateChain<kDim> chain = good;
  chain.states[2].absolute->pose.translation_m.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(ChainSolver<kDim>().Solve(chain));
  EXPECT_EQ(FurthestApart(chain, good), 0.0);
}

}  // namespace
}  // namespace dcloc
