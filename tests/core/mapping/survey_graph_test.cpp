#include "core/mapping/survey_graph.h"

#include <gtest/gtest.h>

#include <map>

namespace dcloc {
namespace {

// Nodes every 10 m on a straight line.
DriveTrack StraightTrack(std::size_t node_count) {
  DriveTrack track;
  for (std::size_t i = 0; i < node_count; ++i) {
    const Pose2 step{.translation_m = {10.0, 0.0}, .yaw_rad = 0.0};
    SurveyNode node;
    node.arc_length_m = 10.0 * static_cast<double>(i);
    node.T_odometry_node = Pose2{.translation_m = {node.arc_length_m, 0.0}, .yaw_rad = 0.0};
    if (i > 0) node.motion = {.pose = step, .covariance = 0.01 * Eigen::Matrix3d::Identity()};
    track.nodes.push_back(node);
  }
  track.arc_length_m = track.nodes.back().arc_length_m;
  return track;
}

class SurveyGraphTest : public ::testing::Test {
 protected:
  std::map<std::size_t, double> PathsFrom(std::size_t node, double limit_m,
                                          const PathCosts& costs = {}) const {
    const auto paths = graph_.PathsFrom(node, limit_m, costs);
    return {paths.begin(), paths.end()};
  }
  void AddFix(std::size_t node, double sigma_m) {
    graph_.fixes.push_back({.node = node, .sigma_m = sigma_m});
  }

  const DriveTrack first_ = StraightTrack(5);
  const DriveTrack second_ = StraightTrack(3);
  SurveyGraph graph_{{&first_, &second_}};
};

TEST_F(SurveyGraphTest, NodesOfAllDrivesStandInOneRow) {
  EXPECT_EQ(graph_.node_count(), 8U);
  EXPECT_EQ(graph_.NodeAt({1, 2}), 7U);
  EXPECT_EQ(graph_.IndexOf(7).drive, 1U);
  EXPECT_EQ(graph_.IndexOf(7).index, 2U);
  EXPECT_EQ(graph_.IndexOf(4).drive, 0U);
  EXPECT_EQ(graph_.node(6).arc_length_m, 10.0);
  EXPECT_EQ(graph_.motions.size(), 6U) << "none joins two drives";
  EXPECT_EQ(graph_.PosesOf(1).back().translation_m.x(), 20.0);
}

TEST_F(SurveyGraphTest, ALoopJoinsDrives) {
  EXPECT_EQ(graph_.GroupOfDrives(), (std::vector<std::size_t>{0, 1}));
  graph_.loops.push_back({.from = 3, .to = 6, .T_from_to = {}});
  EXPECT_EQ(graph_.GroupOfDrives(), (std::vector<std::size_t>{0, 0}));
}

TEST_F(SurveyGraphTest, AFixPlacesAllThatItsDriveIsJoinedWith) {
  AddFix(0, 1.0);
  EXPECT_EQ(graph_.HasFix(), (std::vector<bool>{true, false}));
  graph_.loops.push_back({.from = 3, .to = 6, .T_from_to = {}});
  EXPECT_EQ(graph_.HasFix(), (std::vector<bool>{true, true}));
}

TEST_F(SurveyGraphTest, TheWayBetweenNodesIsWhatWasDriven) {
  EXPECT_EQ(PathsFrom(2, 10.0), (std::map<std::size_t, double>{{1, 10.0}, {2, 0.0}, {3, 10.0}}));
}

TEST_F(SurveyGraphTest, ALoopIsAShortWay) {
  graph_.loops.push_back({.from = 0, .to = 7, .T_from_to = {}});
  const auto paths = PathsFrom(0, 25.0, {.loop_m = 3.0});
  EXPECT_EQ(paths.at(7), 3.0);
  EXPECT_EQ(paths.at(6), 13.0);
  EXPECT_EQ(paths.count(3), 0U);
}

TEST_F(SurveyGraphTest, TwoFixesJoinNodesAsTheyAreCertain) {
  AddFix(0, 0.2);
  AddFix(5, 0.3);
  const auto paths = PathsFrom(0, 61.0, {.path_m_per_fix_sigma = 100.0});
  EXPECT_NEAR(paths.at(5), 50.0, 1e-9);
  EXPECT_NEAR(paths.at(6), 60.0, 1e-9);
  EXPECT_EQ(PathsFrom(0, 49.0).count(5), 0U);
}

}  // namespace
}  // namespace dcloc
