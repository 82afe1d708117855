#include "core/odometry/two_sided_cusum.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace dcloc {
namespace {

constexpr double kPageVariance = 0.01 * 0.01;

TEST(TwoSidedCusumTest, ChanceIsNoChange) {
  TwoSidedCusum test({});
  std::mt19937 random(4);
  std::normal_distribution<double> normal(0.0, 0.01);
  int changes = 0;
  for (int i = 0; i < 3000; ++i) {
    if (test.OnDeviation({normal(random), kPageVariance}, 1.0)) ++changes;
  }
  EXPECT_LE(changes, 1);
}

TEST(TwoSidedCusumTest, AChangeIsFoundAndMeasuredToEitherSide) {
  for (const double rate : {0.03, -0.03}) {
    TwoSidedCusum test({});
    for (int i = 0; i < 10; ++i) EXPECT_FALSE(test.OnDeviation({0.0, kPageVariance}, 2.0));
    std::optional<ScalarEstimate> change;
    int count = 0;
    while (!change && count < 10) {
      change = test.OnDeviation({2.0 * rate, kPageVariance}, 2.0);
      ++count;
    }
    ASSERT_TRUE(change) << rate;
    EXPECT_EQ(count, 3) << "each counts for two deviations, and four are to be exceeded";
    EXPECT_NEAR(change->value, rate, 1e-12);
    EXPECT_NEAR(change->variance, 3.0 * kPageVariance / 36.0, 1e-12);
  }
}

TEST(TwoSidedCusumTest, ASmallChangeTakesLonger) {
  TwoSidedCusum test({});
  int count = 0;
  while (!test.OnDeviation({0.015, kPageVariance}, 1.0)) ++count;
  EXPECT_GT(count, 6);
  EXPECT_LT(count, 12);
}

TEST(TwoSidedCusumTest, HalfWayToAChangeItIsSuspected) {
  TwoSidedCusum test({});
  EXPECT_FALSE(test.UnconfirmedChange());
  for (int i = 0; i < 2; ++i) {
    EXPECT_FALSE(test.UnconfirmedChange());
    EXPECT_FALSE(test.OnDeviation({-0.025, kPageVariance}, 1.0));
  }
  ASSERT_TRUE(test.UnconfirmedChange());
  EXPECT_NEAR(*test.UnconfirmedChange(), -0.025, 1e-12);
  for (int i = 0; i < 3; ++i) test.OnDeviation({0.0, kPageVariance}, 1.0);
  EXPECT_FALSE(test.UnconfirmedChange());
}

TEST(TwoSidedCusumTest, OneThatIsFarOffIsNoChange) {
  TwoSidedCusum test({});
  EXPECT_FALSE(test.OnDeviation({1e6, kPageVariance}, 1.0));
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(test.OnDeviation({0.0, kPageVariance}, 1.0));
}

TEST(TwoSidedCusumTest, DeviationsThatVaryByMoreThanTheySayAreNoChange) {
  TwoSidedCusum test({});
  std::mt19937 random(4);
  std::normal_distribution<double> normal(0.0, 0.1);
  int changes = 0;
  double before = normal(random);
  for (int i = 0; i < 1000; ++i) {  // of neighbouring poses
    const double now = normal(random);
    if (test.OnDeviation({now - before, kPageVariance}, 1.0)) ++changes;
    before = now;
  }
  EXPECT_LE(changes, 20);
}

TEST(TwoSidedCusumTest, WhatTookNoTimeSaysNothing) {
  TwoSidedCusum test({});
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(test.OnDeviation({1.0, kPageVariance}, 0.0));
}

TEST(TwoSidedCusumTest, ItsOptionsAreBounded) {
  EXPECT_TRUE(Validate(TwoSidedCusumOptions{}).ok());
  EXPECT_FALSE(Validate(TwoSidedCusumOptions{.max_sigmas = std::nan("")}).ok());
  EXPECT_FALSE(Validate(TwoSidedCusumOptions{.limit_sigmas = -1.0}).ok());
}

}  // namespace
}  // namespace dcloc
