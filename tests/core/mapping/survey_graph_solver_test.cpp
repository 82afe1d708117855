#include "core/mapping/survey_graph_solver.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dcloc {
namespace {

// A square ring of 40 nodes, 10 m apart, whose odometry turns a little too far at each of them.
struct Ring {
  std::vector<Pose2> T_truth;
  std::vector<Pose2> T_guess;
  std::vector<SurveyEdge> edges;

  Ring() {
    T_truth = T_guess = {Pose2{}};
    for (std::size_t i = 1; i < 40; ++i) {
      const Pose2 step{.translation_m = {10.0, 0.0}, .yaw_rad = i % 10 == 0 ? M_PI / 2 : 0.0};
      Pose2 measured = step;
      measured.yaw_rad += 0.004;
      T_truth.push_back(T_truth.back() * step);
      T_guess.push_back(T_guess.back() * measured);
      edges.push_back(Edge(i - 1, i, measured, 0.1, 0.005));
      edges.back().is_certain = true;
    }
  }
  static SurveyEdge Edge(std::size_t from, std::size_t to, const Pose2& T, double sigma_m,
                         double sigma_rad) {
    return {.from = from,
            .to = to,
            .T_from_to = {.pose = T,
                          .covariance = Eigen::Vector3d(sigma_m * sigma_m, sigma_m * sigma_m,
                                                        sigma_rad * sigma_rad)
                                            .asDiagonal()}};
  }
  void AddLoop(std::size_t from, std::size_t to, const Pose2& off = {}) {
    edges.push_back(Edge(from, to, T_truth[from].Inverse() * T_truth[to] * off, 0.1, 0.003));
  }
  double MaxError(const std::vector<Pose2>& T) const {
    double error_m = 0.0;
    for (std::size_t i = 0; i < T.size(); ++i) {
      error_m = std::max(error_m, (T[i].translation_m - T_truth[i].translation_m).norm());
    }
    return error_m;
  }
};

TEST(SurveyGraphSolverTest, LoopsTakeTheDriftOut) {
  Ring ring;
  for (std::size_t i = 0; i < 4; ++i) ring.AddLoop(i, 36 + i);
  const auto solution = SolveSurveyGraph(ring.T_guess, ring.edges, {}, {});
  ASSERT_TRUE(solution.ok()) << solution.status();
  EXPECT_GT(ring.MaxError(ring.T_guess), 10.0);
  EXPECT_LT(ring.MaxError(solution->T_map_nodes), 2.0);
  for (const double weight : solution->edge_weights) EXPECT_GT(weight, 0.9);
}

TEST(SurveyGraphSolverTest, WrongLoopBendsNothing) {
  Ring right;
  for (std::size_t i = 0; i < 4; ++i) right.AddLoop(i, 36 + i);
  Ring wrong = right;
  wrong.AddLoop(5, 25, {.translation_m = {30.0, 10.0}});
  wrong.AddLoop(12, 33, {.yaw_rad = 1.0});
  const auto expected = SolveSurveyGraph(right.T_guess, right.edges, {}, {});
  const auto solution = SolveSurveyGraph(wrong.T_guess, wrong.edges, {}, {});
  ASSERT_TRUE(expected.ok() && solution.ok());
  EXPECT_LT(solution->edge_weights[wrong.edges.size() - 1], 0.01);
  EXPECT_LT(solution->edge_weights[wrong.edges.size() - 2], 0.01);
  for (std::size_t i = 0; i < expected->T_map_nodes.size(); ++i) {
    EXPECT_NEAR(
        (solution->T_map_nodes[i].translation_m - expected->T_map_nodes[i].translation_m).norm(),
        0.0, 0.01);
  }
}

TEST(SurveyGraphSolverTest, MultipathDoesNotPull) {
  Ring ring;
  std::vector<NodeFix> fixes;
  for (std::size_t i = 0; i < 40; i += 2) {
    fixes.push_back({.node = i, .p_map = ring.T_truth[i].translation_m, .sigma_m = 1.0});
    if (i == 20 || i == 22) fixes.back().p_map.x() += 40.0;
  }
  const auto solution = SolveSurveyGraph(ring.T_guess, ring.edges, fixes, {});
  ASSERT_TRUE(solution.ok()) << solution.status();
  EXPECT_LT(ring.MaxError(solution->T_map_nodes), 2.0);  // a fix alone would pull by 40 m
  EXPECT_LT(solution->fix_weights[10], 0.01);
  EXPECT_LT(solution->fix_weights[11], 0.01);
  EXPECT_GT(solution->fix_weights[5], 0.9);
}

TEST(SurveyGraphSolverTest, EachPartIsHeldAtItsFirstNode) {
  const std::vector<Pose2> T_guess = {
      {}, {.translation_m = {9, 0}}, {.translation_m = {50, 7}}, {.translation_m = {59, 7}}};
  const Pose2 step{.translation_m = {10.0, 0.0}};
  const std::vector<SurveyEdge> edges = {Ring::Edge(0, 1, step, 0.1, 0.01),
                                         Ring::Edge(2, 3, step, 0.1, 0.01)};
  EXPECT_EQ(PartsOf(4, edges), (std::vector<std::size_t>{0, 0, 2, 2}));
  const auto solution = SolveSurveyGraph(T_guess, edges, {}, {});
  ASSERT_TRUE(solution.ok()) << solution.status();
  EXPECT_NEAR(solution->T_map_nodes[1].translation_m.x(), 10.0, 1e-6);
  EXPECT_NEAR(solution->T_map_nodes[3].translation_m.x(), 60.0, 1e-6);
  EXPECT_NEAR(solution->T_map_nodes[3].translation_m.y(), 7.0, 1e-6);
}

}  // namespace
}  // namespace dcloc
