#include "client/rosbag/transform_tree.h"

#include <gtest/gtest.h>

#include <chrono>
#include <numbers>
#include <string>

namespace dcloc::rosbag {
namespace {

using std::chrono::milliseconds;

constexpr Stamp kStart{std::chrono::seconds(1'700'000'000)};

Pose3 At(double x, double y, double yaw_rad = 0.0) { return Embed(Pose2{{x, y}, yaw_rad}); }

TransformTree Tree() {
  TransformTree tree;
  tree.Add({kStart, "base_link", "front", At(3.0, 0.0)}, true);
  tree.Add({kStart, "base_link", "left", At(0.0, 1.0, 0.5 * std::numbers::pi)}, true);
  // As recorded: not in the order of their stamps.
  tree.Add({kStart + milliseconds(500), "map", "base_link", At(10.0, 0.0)}, false);
  tree.Add({kStart, "map", "base_link", At(0.0, 0.0)}, false);
  tree.Sort();
  return tree;
}

TEST(TransformTreeTest, TwoMountsOfAVehicleSeeOneAnother) {
  const auto T_left_front = Tree().Static("left", "front");
  ASSERT_TRUE(T_left_front.has_value());
  EXPECT_NEAR(T_left_front->translation_m.x(), -1.0, 1e-12);  // the left one looks along +y
  EXPECT_NEAR(T_left_front->translation_m.y(), -3.0, 1e-12);
  EXPECT_FALSE(Tree().Static("map", "front").has_value());  // what moves is not static
  EXPECT_FALSE(Tree().Static("base_link", "rear").has_value());
}

TEST(TransformTreeTest, BetweenTwoSamplesAPoseIsInterpolated) {
  const TransformTree tree = Tree();
  const auto front_x = [&](milliseconds after) {
    const auto T_map_front = tree.At("map", "front", kStart + after);
    return T_map_front ? T_map_front->translation_m.x() : -1.0;
  };
  EXPECT_EQ(front_x(milliseconds(0)), 3.0);
  EXPECT_NEAR(front_x(milliseconds(250)), 8.0, 1e-9);
  EXPECT_EQ(front_x(milliseconds(500)), 13.0);
  EXPECT_EQ(front_x(milliseconds(501)), -1.0);  // nothing is extrapolated
  EXPECT_EQ(front_x(milliseconds(-1)), -1.0);
}

TEST(TransformTreeTest, AcrossAGapOfMoreThanASecondThereIsNoPose) {
  TransformTree tree = Tree();
  tree.Add({kStart + milliseconds(1501), "map", "base_link", At(20.0, 0.0)}, false);
  tree.Sort();
  EXPECT_FALSE(tree.At("map", "base_link", kStart + milliseconds(1000)).has_value());
  EXPECT_TRUE(tree.At("map", "base_link", kStart + milliseconds(1501)).has_value());
}

TEST(TransformTreeTest, FramesThatGoRoundInACircleEnd) {
  TransformTree tree;
  tree.Add({kStart, "a", "b", At(1.0, 0.0)}, true);
  tree.Add({kStart, "b", "a", At(1.0, 0.0)}, true);
  tree.Sort();
  EXPECT_FALSE(tree.Static("map", "a").has_value());
  EXPECT_FALSE(tree.At("map", "a", kStart).has_value());
}

}  // namespace
}  // namespace dcloc::rosbag
