#pragma once

#include <Eigen/Cholesky>
#include <vector>

#include "core/posegraph/state_chain.h"

namespace dcloc {

/// Finds the poses of a chain by Gauss-Newton. Only neighbours are tied, so the normal equations
/// are block tridiagonal: a step costs as much as the chain is long. Keeps its memory from one
/// chain to the next.
template <int Dim>
class ChainSolver {
 public:
  /// False, and the poses stay as they were, when a few steps do not lead to where the gradient is
  /// zero and the cost no higher than it was: so far off, it takes a general solver.
  bool Solve(StateChain<Dim>& chain);

 private:
  struct Edge {
    Pose<Dim> measured;
    TangentMatrix<Dim> information;
  };
  // A state's part of the problem and of its normal equations.
  struct Row {
    Edge tie;                      // to the state before; of the first state, the prior
    std::optional<Edge> absolute;  // pose factor
    Pose<Dim> pose;
    TangentMatrix<Dim> diagonal;
    TangentMatrix<Dim> before;  // of the state before with this one
    Tangent<Dim> gradient;
    Eigen::LLT<TangentMatrix<Dim>> eliminated;
    Tangent<Dim> step;
  };

  static Edge Weigh(const PoseEstimate<Dim>& measured);
  void Begin(const StateChain<Dim>& chain);
  double Linearize();
  double AddToMap(const Edge& edge, Row& row);
  double AddBetween(const Edge& edge, Row& from, Row& to);
  void SolveForSteps();

  std::vector<Row> rows_;
};

}  // namespace dcloc
