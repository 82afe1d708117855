#include "core/posegraph/pose_graph.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <type_traits>

#include "tests/core/posegraph/chain.h"

namespace dcloc {
namespace {

template <typename Dimension>
class PoseGraphTest : public ::testing::Test {};

using Dimensions = ::testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(PoseGraphTest, Dimensions);

template <int Dim>
Tangent<Dim> ErrorOf(const Pose<Dim>& estimate, const Pose<Dim>& truth) {
  return Log(truth.Inverse() * estimate);
}

// The textbook's Kalman filter over the errors on the right of the true poses, to first order.
template <int Dim>
struct Kalman {
  Tangent<Dim> error;
  TangentMatrix<Dim> covariance;

  void Predict(const TangentMatrix<Dim>& odometry, const Tangent<Dim>& noise) {
    const TangentMatrix<Dim> A = Adjoint(StepAhead<Dim>().Inverse());
    error = A * error + noise;
    covariance = A * covariance * A.transpose() + odometry;
  }
  void Update(const TangentMatrix<Dim>& loop, const Tangent<Dim>& noise) {
    const TangentMatrix<Dim> gain = covariance * (covariance + loop).inverse();
    error += gain * (noise - error);
    covariance = (TangentMatrix<Dim>::Identity() - gain) * covariance;
  }
};

template <int Dim>
PoseGraph<Dim> Run(const Chain<Dim>& chain, const PoseGraphOptions& options) {
  PoseGraph<Dim> graph(options);
  graph.Reset(chain.prior);
  for (const auto& step : chain.steps) {
    graph.AddState(step.odometry);
    graph.AddAbsolutePose(step.factor);
    graph.Solve();
  }
  return graph;
}

class PoseGraphWindowTest : public ::testing::TestWithParam<int> {};

template <int Dim>
void ExpectKalman(int window) {
  const TangentMatrix<Dim> odometry = Diagonal<Dim>(2e-3, 5e-4);
  const TangentMatrix<Dim> loop = Diagonal<Dim>(4e-3, 1e-3);
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Chain<Dim> chain(25, odometry, loop, seed);
    Kalman<Dim> filter{chain.prior_noise, loop};
    PoseGraph<Dim> graph({.window = window, .gate_outliers = false});
    graph.Reset(chain.prior);
    for (std::size_t i = 0; i < chain.steps.size(); ++i) {
      const auto& step = chain.steps[i];
      filter.Predict(odometry, step.odometry_noise);
      graph.AddState(step.odometry);
      if (i % 4 != 3) {  // now and then a state without a registration
        filter.Update(loop, step.loop_noise);
        graph.AddAbsolutePose(step.factor);
      }
      graph.Solve();
      const PoseEstimate<Dim> newest = graph.Newest();
      const double sigma = std::sqrt(filter.covariance.trace());
      EXPECT_LT((ErrorOf<Dim>(newest.pose, step.truth) - filter.error).norm(), 0.01 * sigma);
      EXPECT_LT((newest.covariance - filter.covariance).norm(), 0.02 * filter.covariance.norm());
    }
  }
}

TEST_P(PoseGraphWindowTest, IsTheKalmanFilterForSmallNoise) {
  ExpectKalman<2>(GetParam());
  ExpectKalman<3>(GetParam());
}

INSTANTIATE_TEST_SUITE_P(Windows, PoseGraphWindowTest, ::testing::Values(1, 2, 10, 100));

TYPED_TEST(PoseGraphTest, AShortWindowWithItsPriorGivesNearlyTheAnswerOfALongOne) {
  constexpr int kDim = TypeParam::value;
  const Chain<kDim> chain(60, Diagonal<kDim>(0.1, 0.01), Diagonal<kDim>(0.3, 0.03), 7);
  const PoseGraph<kDim> short_graph = Run(chain, {.window = 3, .gate_outliers = false});
  const PoseGraph<kDim> long_graph = Run(chain, {.window = 100, .gate_outliers = false});
  EXPECT_EQ(short_graph.size(), 3U);
  EXPECT_EQ(long_graph.size(), 61U);
  const PoseEstimate<kDim> a = short_graph.Newest();
  const PoseEstimate<kDim> b = long_graph.Newest();
  const Tangent<kDim> apart = ErrorOf<kDim>(a.pose, b.pose);
  EXPECT_LT(std::sqrt(apart.dot(b.covariance.inverse() * apart)), 0.1);
  EXPECT_LT((a.covariance - b.covariance).norm(), 0.05 * b.covariance.norm());
}

TYPED_TEST(PoseGraphTest, TheSolutionWeighsByTheReusedCovarianceTheTestByTheOwn) {
  constexpr int kDim = TypeParam::value;
  const TangentMatrix<kDim> one = Diagonal<kDim>(0.01, 0.01);
  PoseGraph<kDim> graph;
  graph.Reset({{}, one});
  graph.AddState({{}, Diagonal<kDim>(1e-4, 1e-4)});
  const Tangent<kDim> xi = 0.02 * Tangent<kDim>::Unit(0);
  const InnovationTest test = graph.AddAbsolutePose({Exp(xi), one, 9.0 * one});
  EXPECT_NEAR(test.squared_distance, 4.0 / 2.0, 0.01);
  graph.Solve();
  EXPECT_NEAR(Log(graph.Newest().pose)(0), 0.02 / 10.0, 1e-5);
  EXPECT_NEAR(graph.Newest().covariance(0, 0), 0.9 * one(0, 0), 1e-6);
}

TYPED_TEST(PoseGraphTest, SingleOutliersAreCutAndOdometryHoldsTheState) {
  constexpr int kDim = TypeParam::value;
  const Chain<kDim> chain(40, Diagonal<kDim>(0.02, 0.002), Diagonal<kDim>(0.05, 0.005), 8);
  PoseGraph<kDim> with;
  PoseGraph<kDim> without;
  with.Reset(chain.prior);
  without.Reset(chain.prior);
  for (std::size_t i = 0; i < chain.steps.size(); ++i) {
    const auto& step = chain.steps[i];
    with.AddState(step.odometry);
    without.AddState(step.odometry);
    if (i % 10 == 5) {
      AbsolutePoseFactor<kDim> outlier = step.factor;
      outlier.pose = outlier.pose * Exp(Tangent<kDim>(0.8 * Tangent<kDim>::Unit(1)));
      const InnovationTest test = with.AddAbsolutePose(outlier);
      EXPECT_FALSE(test.is_accepted);
      EXPECT_GT(test.squared_distance, 50.0);
    } else {
      EXPECT_EQ(with.AddAbsolutePose(step.factor).is_accepted,
                without.AddAbsolutePose(step.factor).is_accepted);
    }
    with.Solve();
    without.Solve();
    // As if the outlier had never been there.
    EXPECT_LT(ErrorOf<kDim>(with.Newest().pose, without.Newest().pose).norm(), 1e-9);
    EXPECT_LT(ErrorOf<kDim>(with.Newest().pose, step.truth).norm(), 0.25);
  }
}

TYPED_TEST(PoseGraphTest, WithoutTruncationTheOutlierPulls) {
  constexpr int kDim = TypeParam::value;
  const Chain<kDim> chain(5, Diagonal<kDim>(0.02, 0.002), Diagonal<kDim>(0.05, 0.005), 9);
  PoseGraph<kDim> graph = Run(chain, {.gate_outliers = false});
  graph.AddState(chain.steps[4].odometry);
  const PoseEstimate<kDim> before = graph.Newest();
  AbsolutePoseFactor<kDim> outlier{before.pose * Exp(Tangent<kDim>(Tangent<kDim>::Unit(0))),
                                   Diagonal<kDim>(0.05, 0.005), Diagonal<kDim>(0.05, 0.005)};
  EXPECT_TRUE(graph.AddAbsolutePose(outlier).is_accepted);
  graph.Solve();
  EXPECT_GT(ErrorOf<kDim>(graph.Newest().pose, before.pose)(0), 0.05);
}

TYPED_TEST(PoseGraphTest, GoodEdgesAreCutAtTheTestsOwnRate) {
  constexpr int kDim = TypeParam::value;
  const TangentMatrix<kDim> odometry = Diagonal<kDim>(0.02, 0.002);
  const TangentMatrix<kDim> loop = Diagonal<kDim>(0.05, 0.005);
  constexpr int kTrials = 1500;
  int cut = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    // The edges before the last one are taken as they are, so that the state that it is tested
    // against is an honest Gaussian.
    Chain<kDim> chain(4, odometry, loop, 1000 + static_cast<unsigned>(trial));
    const auto last = chain.steps.back();
    chain.steps.pop_back();
    PoseGraph<kDim> graph;
    graph.Reset(Run(chain, {.gate_outliers = false}).Newest());
    graph.AddState(last.odometry);
    cut += graph.AddAbsolutePose(last.factor).is_accepted ? 0 : 1;
  }
  // 5 % of 1500: deviation 0.56 %; four times that.
  EXPECT_NEAR(static_cast<double>(cut) / kTrials, 0.05, 0.0225);
}

TYPED_TEST(PoseGraphTest, FailuresThatAgreeWithOneAnotherAreAllCut) {
  constexpr int kDim = TypeParam::value;
  const Chain<kDim> chain(20, Diagonal<kDim>(0.02, 0.002), Diagonal<kDim>(0.05, 0.005), 10);
  // 3 m aside, three times in a row: the second and third agree with the match before them.
  const Pose<kDim> aside = Exp(Tangent<kDim>(3.0 * Tangent<kDim>::Unit(1)));
  PoseGraph<kDim> graph;
  graph.Reset(chain.prior);
  for (std::size_t i = 0; i < chain.steps.size(); ++i) {
    const auto& step = chain.steps[i];
    graph.AddState(step.odometry);
    AbsolutePoseFactor<kDim> loop = step.factor;
    const bool wrong = i >= 10 && i < 13;
    if (wrong) loop.pose = loop.pose * aside;
    const InnovationTest test = graph.AddAbsolutePose(loop);
    if (wrong) {
      EXPECT_FALSE(test.is_accepted) << "step " << i;
    }
    graph.Solve();
    EXPECT_LT(ErrorOf<kDim>(graph.Newest().pose, step.truth).norm(), 0.25) << "step " << i;
  }
}

TYPED_TEST(PoseGraphTest, UncertaintyGrowsWithoutLoopsAndLetsALaterOneIn) {
  constexpr int kDim = TypeParam::value;
  const TangentMatrix<kDim> odometry = Diagonal<kDim>(0.05, 0.005);
  PoseGraph<kDim> graph;
  graph.Reset({{}, Diagonal<kDim>(0.05, 0.005)});
  const Tangent<kDim> aside = 0.6 * Tangent<kDim>::Unit(1);
  const TangentMatrix<kDim> loop = Diagonal<kDim>(0.05, 0.005);
  double trace = graph.Newest().covariance.trace();
  graph.AddState({{}, odometry});
  EXPECT_FALSE(graph.AddAbsolutePose({Exp(aside), loop, loop}).is_accepted);
  for (int i = 0; i < 50; ++i) {
    graph.AddState({{}, odometry});
    graph.Solve();
    EXPECT_GT(graph.Newest().covariance.trace(), trace);
    trace = graph.Newest().covariance.trace();
  }
  EXPECT_TRUE(graph.AddAbsolutePose({Exp(aside), loop, loop}).is_accepted);
}

TYPED_TEST(PoseGraphTest, AnotherFrameChangesNothingBetweenThePoses) {
  constexpr int kDim = TypeParam::value;
  const Chain<kDim> chain(30, Diagonal<kDim>(0.05, 0.005), Diagonal<kDim>(0.1, 0.01), 11);
  const Pose<kDim> T_new_old = Exp(Tangent<kDim>(Tangent<kDim>::LinSpaced(-4.0, 1.5)));
  PoseGraph<kDim> stays;
  PoseGraph<kDim> moves;
  stays.Reset(chain.prior);
  moves.Reset(chain.prior);
  for (std::size_t i = 0; i < chain.steps.size(); ++i) {
    const auto& step = chain.steps[i];
    stays.AddState(step.odometry);
    moves.AddState(step.odometry);
    if (i == 15) moves.ChangeFrame(T_new_old);
    AbsolutePoseFactor<kDim> loop = step.factor;
    if (i >= 15) loop.pose = T_new_old * loop.pose;
    const InnovationTest a = stays.AddAbsolutePose(step.factor);
    const InnovationTest b = moves.AddAbsolutePose(loop);
    EXPECT_NEAR(a.squared_distance, b.squared_distance, 1e-4 * (1.0 + a.squared_distance));
    EXPECT_EQ(a.is_accepted, b.is_accepted);
    stays.Solve();
    moves.Solve();
    const Pose<kDim> back =
        i < 15 ? moves.Newest().pose : T_new_old.Inverse() * moves.Newest().pose;
    EXPECT_LT(ErrorOf<kDim>(back, stays.Newest().pose).norm(), 1e-5);
    EXPECT_LT((moves.Newest().covariance - stays.Newest().covariance).norm(), 1e-9);
  }
}

TYPED_TEST(PoseGraphTest, ALoopThatIsNoNumberIsCut) {
  constexpr int kDim = TypeParam::value;
  const Chain<kDim> chain(3, Diagonal<kDim>(0.05, 0.005), Diagonal<kDim>(0.1, 0.01), 12);
  PoseGraph<kDim> graph = Run(chain, {});
  const PoseEstimate<kDim> before = graph.Newest();
  AbsolutePoseFactor<kDim> loop = chain.steps.back().factor;
  loop.pose.translation_m.x() = std::numeric_limits<double>::quiet_NaN();
  PoseGraph<kDim> fresh;
  fresh.Reset(before);
  EXPECT_FALSE(fresh.AddAbsolutePose(loop).is_accepted);
  fresh.Solve();
  EXPECT_LT(ErrorOf<kDim>(fresh.Newest().pose, before.pose).norm(), 1e-9);
}

TYPED_TEST(PoseGraphTest, APriorThatIsExactIsKeptAndLoopsAfterItCount) {
  constexpr int kDim = TypeParam::value;
  PoseGraph<kDim> graph;
  graph.Reset({{}, TangentMatrix<kDim>::Zero()});
  const TangentMatrix<kDim> one = Diagonal<kDim>(0.1, 0.1);
  const Tangent<kDim> xi = 0.1 * Tangent<kDim>::Unit(0);
  EXPECT_TRUE(graph.AddAbsolutePose({Exp(xi), one, one}).is_accepted);
  graph.Solve();
  EXPECT_LT(Log(graph.Newest().pose).norm(), 1e-6);
  graph.AddState({{}, one});
  EXPECT_TRUE(graph.AddAbsolutePose({Exp(xi), one, one}).is_accepted);
  graph.Solve();
  // Odometry and registration are worth the same.
  EXPECT_NEAR(Log(graph.Newest().pose)(0), 0.05, 1e-4);
  EXPECT_NEAR(graph.Newest().covariance(0, 0), 0.5 * one(0, 0), 1e-6);
}

TYPED_TEST(PoseGraphTest, ResetForgets) {
  constexpr int kDim = TypeParam::value;
  const Chain<kDim> chain(12, Diagonal<kDim>(0.05, 0.005), Diagonal<kDim>(0.1, 0.01), 13);
  PoseGraph<kDim> graph = Run(chain, {});
  EXPECT_EQ(graph.size(), 10U);
  graph.Reset(chain.prior);
  EXPECT_EQ(graph.size(), 1U);
  EXPECT_LT(ErrorOf<kDim>(graph.Newest().pose, chain.prior.pose).norm(), 1e-12);
  EXPECT_TRUE(PoseGraph<kDim>().empty());
}

TYPED_TEST(PoseGraphTest, WithoutOtherNoiseTheNoiseIsTheWeights) {
  constexpr int kDim = TypeParam::value;
  const Chain<kDim> chain(30, Diagonal<kDim>(0.03, 0.004), Diagonal<kDim>(0.1, 0.01), 5);
  const PoseGraph<kDim> graph = Run<kDim>(chain, {.gate_outliers = false});
  const TangentMatrix<kDim> covariance = graph.Newest().covariance;
  EXPECT_LT((graph.NewestNoiseCovariance() - covariance).norm(), 1e-6 * covariance.norm());
}

TYPED_TEST(PoseGraphTest, TheNoiseIsThatOfTheGainsThatTheWeightsGive) {
  // Cautious weights and smaller noises: what the errors of many drives really come to.
  constexpr int kDim = TypeParam::value;
  constexpr int kRuns = 400;
  const TangentMatrix<kDim> odometry = Diagonal<kDim>(0.02, 0.002);
  const TangentMatrix<kDim> loop = Diagonal<kDim>(0.06, 0.006);
  TangentMatrix<kDim> sampled = TangentMatrix<kDim>::Zero();
  TangentMatrix<kDim> stated;
  for (int run = 0; run < kRuns; ++run) {
    Chain<kDim> chain(25, odometry, loop, static_cast<unsigned>(100 + run));
    PoseGraph<kDim> graph({.gate_outliers = false});
    graph.Reset(chain.prior);
    for (auto& step : chain.steps) {
      step.odometry.covariance = 4.0 * odometry;
      step.factor.weight_covariance = 30.0 * loop;
      step.factor.noise_covariance = loop;
      graph.AddState(step.odometry, odometry);
      graph.AddAbsolutePose(step.factor);
      graph.Solve();
    }
    const Tangent<kDim> error = ErrorOf<kDim>(graph.Newest().pose, chain.steps.back().truth);
    sampled += error * error.transpose() / kRuns;
    stated = graph.NewestNoiseCovariance();
  }
  for (int i = 0; i < Pose<kDim>::kDof; ++i) {
    EXPECT_NEAR(sampled(i, i) / stated(i, i), 1.0, 0.25) << i;
  }
}

TYPED_TEST(PoseGraphTest, WhatLastsPassesTheWeightsGains) {
  // Every absolute pose is off by the same; odometry is exact.
  constexpr int kDim = TypeParam::value;
  Chain<kDim> chain(40, Diagonal<kDim>(1e-9, 1e-9), Diagonal<kDim>(1e-9, 1e-9), 8);
  const Tangent<kDim> fault = Tangent<kDim>::Constant(2e-3);
  PoseGraph<kDim> graph({.gate_outliers = false});
  PoseGraph<kDim> without({.gate_outliers = false});
  graph.Reset(chain.prior);
  without.Reset(chain.prior);
  for (auto& step : chain.steps) {
    step.odometry.covariance = Diagonal<kDim>(0.02, 0.002);
    step.factor.weight_covariance = Diagonal<kDim>(0.3, 0.03);
    step.factor.pose = step.truth * Exp(fault);
    for (PoseGraph<kDim>* one : {&graph, &without}) one->AddState(step.odometry);
    without.AddAbsolutePose(step.factor);
    step.factor.systematic.col(0) = fault;
    graph.AddAbsolutePose(step.factor);
    graph.Solve();
  }
  const Tangent<kDim> error = ErrorOf<kDim>(graph.Newest().pose, chain.steps.back().truth);
  const TangentMatrix<kDim> systematic =
      graph.NewestNoiseCovariance() - without.NewestNoiseCovariance();
  EXPECT_GT(error.norm(), 1e-3);
  EXPECT_LT((systematic - error * error.transpose()).norm(), 0.1 * error.squaredNorm());
}

}  // namespace
}  // namespace dcloc
