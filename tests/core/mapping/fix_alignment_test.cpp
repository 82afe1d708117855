#include "core/mapping/fix_alignment.h"

#include <gtest/gtest.h>

namespace dcloc {
namespace {

const Pose2 kTruth{.translation_m = {100.0, -40.0}, .yaw_rad = 2.0};

// Nodes along a bend with a fix each; of `wrong` in ten, the fix is 25 m off, each elsewhere.
std::vector<NodeFix> Fixes(std::vector<Pose2>& T_nodes, int wrong) {
  std::vector<NodeFix> fixes;
  for (std::size_t i = 0; i < 20; ++i) {
    const double at = static_cast<double>(i);
    T_nodes.push_back({.translation_m = {5.0 * at, 0.1 * at * at}});
    const bool is_wrong = static_cast<int>(i % 10) < wrong;
    const Eigen::Vector2d off = is_wrong ? Eigen::Vector2d(25.0 * std::cos(at), 25.0 * std::sin(at))
                                         : Eigen::Vector2d(0, 0);
    fixes.push_back({.node = i, .p_map = kTruth * T_nodes.back().translation_m + off});
  }
  return fixes;
}

TEST(AlignWithFixesTest, WithstandsWrongFixes) {
  for (const int wrong : {0, 4}) {
    std::vector<Pose2> T_nodes;
    const std::vector<NodeFix> fixes = Fixes(T_nodes, wrong);
    const auto T = AlignWithFixes(T_nodes, fixes, 1.0);
    ASSERT_TRUE(T.has_value()) << wrong;
    EXPECT_NEAR((T->translation_m - kTruth.translation_m).norm(), 0.0, 1e-6) << wrong;
    EXPECT_NEAR(T->yaw_rad, kTruth.yaw_rad, 1e-6) << wrong;
  }
}

TEST(AlignWithFixesTest, RefusesTooFewAndTooNear) {
  std::vector<Pose2> T_nodes;
  const std::vector<NodeFix> fixes = Fixes(T_nodes, 0);
  EXPECT_FALSE(AlignWithFixes(T_nodes, std::span(fixes).first(kMinAgreeingFixes - 1), 1.0));
  EXPECT_FALSE(AlignWithFixes(T_nodes, std::span(fixes).first(6), 1.0));  // 25 m driven
  EXPECT_TRUE(AlignWithFixes(T_nodes, std::span(fixes).first(9), 1.0));
}

}  // namespace
}  // namespace dcloc
