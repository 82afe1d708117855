#include "core/mapping/pairwise_consistency.h"

#include <gtest/gtest.h>

namespace dcloc {
namespace {

// Two drives along the same 200 m, the second in a frame of its own.
class PairwiseConsistencyTest : public ::testing::Test {
 protected:
  PairwiseConsistencyTest() {
    for (DriveTrack& track : tracks_) {
      for (int i = 0; i < 20; ++i) {
        track.nodes.push_back({.stamp = Stamp(std::chrono::seconds(i)),
                               .T_odometry_node = {.translation_m = {10.0 * i, 0.0}},
                               .arc_length_m = 10.0 * i});
        track.nodes.back().motion.covariance.setIdentity();
      }
    }
  }
  static SurveyEdge Loop(std::size_t index, double along_m, double yaw_rad = 0.0) {
    return {.from = index,
            .to = 20 + index,
            .T_from_to = {.pose = {.translation_m = {along_m, 0.0}, .yaw_rad = yaw_rad}}};
  }

  DriveTrack tracks_[2];
};

TEST_F(PairwiseConsistencyTest, KeepsThoseThatAgree) {
  const SurveyGraph graph({&tracks_[0], &tracks_[1]});
  const std::vector<SurveyEdge> candidates = {Loop(2, 0.0), Loop(5, 30.0), Loop(8, 0.2),
                                              Loop(11, -0.1)};
  const std::vector<SurveyEdge> confirmed = ConfirmedLoops(candidates, graph, {});
  ASSERT_EQ(confirmed.size(), 3U);
  EXPECT_EQ(confirmed[1].from, 8U);
}

TEST_F(PairwiseConsistencyTest, NeedsSupport) {
  const SurveyGraph graph({&tracks_[0], &tracks_[1]});
  EXPECT_TRUE(ConfirmedLoops({Loop(2, 0.0), Loop(5, 0.0)}, graph, {}).empty());
  EXPECT_TRUE(
      ConfirmedLoops({Loop(2, 0.0), Loop(5, 0.0, 0.3), Loop(8, 0.0, -0.3)}, graph, {}).empty());
}

TEST(ConsistentSetTest, FindsTheLargest) {
  // Three agree, two others agree.
  const auto agrees = [](std::size_t a, std::size_t b) { return (a < 2) == (b < 2); };
  EXPECT_EQ(ConsistentSet(5, agrees), (std::vector<std::size_t>{2, 3, 4}));
  EXPECT_TRUE(ConsistentSet(0, agrees).empty());
}

}  // namespace
}  // namespace dcloc
