#include "core/posegraph/pose_chains.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

#include "tests/core/posegraph/chain.h"

namespace dcloc {
namespace {

constexpr int kSupport = 8;
constexpr PoseGraphOptions kOptions{.takeover_support = kSupport,
                                    .near_takeover_support = kSupport};

// Registrations with a fraction of the noise that they claim, so that chance fails none of them.
Chain<2> QuietChain(int count) {
  Chain<2> chain(count, Diagonal<2>(0.005, 0.0005), Diagonal<2>(0.01, 0.001), 3);
  for (auto& step : chain.steps) {
    step.odometry.covariance = Diagonal<2>(0.02, 0.002);
    step.factor.covariance = step.factor.weight_covariance = Diagonal<2>(0.05, 0.005);
  }
  chain.prior.covariance = Diagonal<2>(0.05, 0.005);
  return chain;
}

double DistanceTo(const Pose2& truth, const PoseChains<2>& chains) {
  return (chains.Newest().pose.translation_m - truth.translation_m).norm();
}

AbsolutePoseFactor<2> Aside(AbsolutePoseFactor<2> loop, double y_m) {
  loop.pose = loop.pose * Pose2{.translation_m = {0.0, y_m}};
  return loop;
}

// The outcome of every step's edge; `loop_at(i)` gives the edge.
template <typename LoopAt>
std::vector<InnovationTest> Drive(const Chain<2>& chain, PoseChains<2>& chains,
                                  const LoopAt& loop_at) {
  std::vector<InnovationTest> tests;
  for (std::size_t i = 0; i < chain.steps.size(); ++i) {
    chains.AddState(chain.steps[i].odometry);
    tests.push_back(chains.AddAbsolutePose(loop_at(i)));
  }
  return tests;
}

TEST(PoseChainsTest, APositionThatFailsIsNoFactorOfTheAlternative) {
  const Chain<2> chain = QuietChain(2 * kSupport);
  PoseChains<2> chains(kOptions);
  PoseEstimate<2> wrong = chain.prior;
  wrong.pose.translation_m.y() += 5.0;
  chains.Reset(wrong);
  for (int i = 0; i < kSupport; ++i) {
    const auto& step = chain.steps[static_cast<std::size_t>(i)];
    chains.AddState(step.odometry);
    EXPECT_EQ(chains.AddAbsolutePose(step.factor).is_accepted, i + 1 == kSupport) << i;
    const Eigen::Vector2d before_m = chains.Newest().pose.translation_m;
    EXPECT_FALSE(chains.AddPosition(Aside(step.factor, 20.0)).is_accepted) << i;
    EXPECT_EQ(chains.Newest().pose.translation_m, before_m) << i;
  }
}

TEST(PoseChainsTest, APositionThatAgreesIsFused) {
  const Chain<2> chain = QuietChain(2);
  PoseChains<2> chains(kOptions);
  chains.Reset(chain.prior);
  chains.AddState(chain.steps[0].odometry);
  const double before = chains.Newest().covariance(0, 0);
  EXPECT_TRUE(chains.AddPosition(chain.steps[0].factor).is_accepted);
  EXPECT_LT(chains.Newest().covariance(0, 0), before);
}

TEST(PoseChainsTest, WithoutContradictionItIsThePoseGraph) {
  const Chain<2> chain = QuietChain(30);
  PoseChains<2> chains(kOptions);
  EXPECT_TRUE(chains.empty());
  chains.Reset(chain.prior);
  EXPECT_FALSE(chains.empty());
  PoseGraph<2> graph(kOptions);
  graph.Reset(chain.prior);
  for (const auto& step : chain.steps) {
    chains.AddState(step.odometry);
    graph.AddState(step.odometry);
    EXPECT_EQ(chains.AddAbsolutePose(step.factor).squared_distance,
              graph.AddAbsolutePose(step.factor).squared_distance);
    graph.Solve();
    EXPECT_EQ(chains.Newest().pose.translation_m, graph.Newest().pose.translation_m);
  }
}

TEST(PoseChainsTest, AShorterBurstNeverTakesOver) {
  const Chain<2> chain = QuietChain(40);
  PoseChains<2> chains(kOptions);
  chains.Reset(chain.prior);
  const auto in_burst = [](std::size_t i) { return i >= 10 && i < 10 + kSupport - 1; };
  const auto tests = Drive(chain, chains, [&](std::size_t i) {
    return in_burst(i) ? Aside(chain.steps[i].factor, 3.0) : chain.steps[i].factor;
  });
  for (std::size_t i = 0; i < tests.size(); ++i) EXPECT_EQ(tests[i].is_accepted, !in_burst(i)) << i;
  EXPECT_LT(DistanceTo(chain.steps.back().truth, chains), 0.1);
}

TEST(PoseChainsTest, OneAcceptedEdgeEndsTheContention) {
  const Chain<2> chain = QuietChain(60);
  PoseChains<2> chains(kOptions);
  chains.Reset(chain.prior);
  // Most registrations are wrong, and all the wrong ones agree; every seventh is right.
  const auto tests = Drive(chain, chains, [&](std::size_t i) {
    return i % 7 != 6 ? Aside(chain.steps[i].factor, 3.0) : chain.steps[i].factor;
  });
  for (std::size_t i = 0; i < tests.size(); ++i) EXPECT_EQ(tests[i].is_accepted, i % 7 == 6) << i;
  EXPECT_LT(DistanceTo(chain.steps.back().truth, chains), 0.2);
}

TEST(PoseChainsTest, ScatteredFailuresNeverTakeOver) {
  const Chain<2> chain = QuietChain(60);
  PoseChains<2> chains(kOptions);
  chains.Reset(chain.prior);
  const auto tests = Drive(chain, chains, [&](std::size_t i) {
    return Aside(chain.steps[i].factor, i % 2 == 0 ? 10.0 : -10.0);
  });
  for (const InnovationTest& test : tests) EXPECT_FALSE(test.is_accepted);
  EXPECT_LT(DistanceTo(chain.steps.back().truth, chains), 0.6);
}

TEST(PoseChainsTest, AChainThatIsWrongForGoodIsReplaced) {
  const Chain<2> chain = QuietChain(30);
  PoseChains<2> chains(kOptions);
  PoseEstimate<2> wrong = chain.prior;
  wrong.pose = wrong.pose * Pose2{.translation_m = {0.0, 5.0}, .yaw_rad = 0.1};
  chains.Reset(wrong);
  for (std::size_t i = 0; i < chain.steps.size(); ++i) {
    chains.AddState(chain.steps[i].odometry);
    const InnovationTest test = chains.AddAbsolutePose(chain.steps[i].factor);
    const bool taken_over = i + 1 >= kSupport;
    EXPECT_EQ(test.is_accepted, taken_over) << i;
    // At the takeover it is the distance to the chain that is replaced.
    EXPECT_EQ(test.squared_distance > kOptions.max_squared_distance_planar, i < kSupport) << i;
    if (taken_over) {
      EXPECT_LT(DistanceTo(chain.steps[i].truth, chains), 0.1) << i;
      // What took over was made of a few registrations: it claims no more than that.
      EXPECT_LT(chains.Newest().covariance(0, 0), 0.05 * 0.05);
      EXPECT_GT(chains.Newest().covariance(0, 0), 0.01 * 0.01);
    } else {
      EXPECT_GT(DistanceTo(chain.steps[i].truth, chains), 3.0) << i;
    }
  }
}

TEST(PoseChainsTest, StatesWithoutARegistrationDoNotEndTheContention) {
  const Chain<2> chain = QuietChain(40);
  PoseChains<2> chains(kOptions);
  PoseEstimate<2> wrong = chain.prior;
  wrong.pose.translation_m.y() += 5.0;
  chains.Reset(wrong);
  int given = 0;
  for (std::size_t i = 0; i < chain.steps.size(); ++i) {
    chains.AddState(chain.steps[i].odometry);
    if (i % 3 != 0) continue;
    ++given;
    EXPECT_EQ(chains.AddAbsolutePose(chain.steps[i].factor).is_accepted, given >= kSupport) << i;
  }
  EXPECT_LT(DistanceTo(chain.steps.back().truth, chains), 0.2);
}

TEST(PoseChainsTest, TheContentionSurvivesAChangeOfFrame) {
  const Chain<2> chain = QuietChain(20);
  const Pose2 T_new_old{.translation_m = {-30.0, 12.0}, .yaw_rad = 1.1};
  PoseChains<2> chains(kOptions);
  PoseEstimate<2> wrong = chain.prior;
  wrong.pose.translation_m.y() += 5.0;
  chains.Reset(wrong);
  for (std::size_t i = 0; i < chain.steps.size(); ++i) {
    chains.AddState(chain.steps[i].odometry);
    if (i == 4) chains.ChangeFrame(T_new_old);
    AbsolutePoseFactor<2> loop = chain.steps[i].factor;
    if (i >= 4) loop.pose = T_new_old * loop.pose;
    EXPECT_EQ(chains.AddAbsolutePose(loop).is_accepted, i + 1 >= kSupport) << i;
  }
  EXPECT_LT(DistanceTo(T_new_old * chain.steps.back().truth, chains), 0.1);
}

TEST(PoseChainsTest, AResetDropsTheContender) {
  const Chain<2> chain = QuietChain(kSupport - 1);
  PoseChains<2> chains(kOptions);
  PoseEstimate<2> wrong = chain.prior;
  wrong.pose.translation_m.y() += 5.0;
  chains.Reset(wrong);
  Drive(chain, chains, [&](std::size_t i) { return chain.steps[i].factor; });
  wrong.pose = wrong.pose * Pose2{.translation_m = {50.0, 0.0}};
  chains.Reset(wrong);
  chains.AddState(chain.steps.back().odometry);
  EXPECT_FALSE(chains.AddAbsolutePose(chain.steps.back().factor).is_accepted);
  EXPECT_GT(DistanceTo(chain.steps.back().truth, chains), 20.0);
}

TEST(PoseChainsTest, LoopsThatAreNoNumbersAreCutAndLeaveNothingBehind) {
  const Chain<2> chain = QuietChain(60);
  PoseChains<2> chains(kOptions);
  chains.Reset(chain.prior);
  const auto is_bad = [](std::size_t i) { return i >= 5 && i < 5 + 3 * kSupport; };
  const auto tests = Drive(chain, chains, [&](std::size_t i) {
    AbsolutePoseFactor<2> loop = chain.steps[i].factor;
    if (is_bad(i)) loop.pose.yaw_rad = std::numeric_limits<double>::quiet_NaN();
    return loop;
  });
  for (std::size_t i = 0; i < tests.size(); ++i) EXPECT_EQ(tests[i].is_accepted, !is_bad(i)) << i;
  EXPECT_LT(DistanceTo(chain.steps.back().truth, chains), 0.1);
}

// An estimate that is off by little is corrected sooner than one that all contradict.
TEST(PoseChainsTest, NearOutliersTakeOverSooner) {
  const Chain<2> chain = QuietChain(30);
  const auto first_valid = [&](double aside_m) {
    PoseChains<2> chains({.takeover_support = 8, .near_takeover_support = 4});
    PoseEstimate<2> wrong = chain.prior;
    wrong.pose = wrong.pose * Pose2{.translation_m = {0.0, aside_m}};
    chains.Reset(wrong);
    const auto tests = Drive(chain, chains, [&](std::size_t i) { return chain.steps[i].factor; });
    return std::ranges::find_if(tests, &InnovationTest::is_accepted) - tests.begin();
  };
  EXPECT_EQ(first_valid(0.35), 3);
  EXPECT_EQ(first_valid(5.0), 7);
}

}  // namespace
}  // namespace dcloc
