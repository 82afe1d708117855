#include "core/uncertainty/range_biases.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/core/options/option_fields_check.h"

namespace dcloc {
namespace {

constexpr std::size_t kSeenPoints = 80;

// Scans of a radar whose ranges are too long by `true_m`, in a map that they fit within half a
// metre. The vehicle drives `step_m` between two of them.
class Drive {
 public:
  explicit Drive(double true_m) : true_m_(true_m) {}

  // Returns how often the bias of radar 0 was corrected.
  int Go(RangeBiases& biases, int scans, double step_m = 1.5) const {
    int corrections = 0;
    for (int i = 0; i < scans; ++i) {
      biases.OnMotion(step_m);
      if (!biases.IsDue(0, kSeenPoints)) continue;
      const double left_m = true_m_ - (biases.bias_m(0) ? biases.bias_m(0)->value : 0.0);
      const double tried_m = biases.options().step_m;
      const RangeFits fits = {.point_count = kSeenPoints,
                              .shorter = FitAt(left_m - tried_m),
                              .as_measured = FitAt(left_m),
                              .longer = FitAt(left_m + tried_m)};
      corrections += biases.OnFits(0, fits, kAbsorbed_m).has_value() ? 1 : 0;
    }
    return corrections;
  }

  static constexpr double kAbsorbed_m = 0.9;

 private:
  static double FitAt(double off_m) { return 0.4 + 0.16 * std::exp(-0.5 * off_m * off_m / 0.25); }

  double true_m_;
};

TEST(RangeBiasOptionsTest, EachFieldIsBounded) { ExpectEachFieldIsBounded<RangeBiasOptions>(); }

TEST(RangeBiasesTest, RangesThatAreRightStay) {
  RangeBiases biases(2, {});
  EXPECT_EQ(Drive(0.0).Go(biases, 1000), 0);
  EXPECT_FALSE(biases.bias_m(0));
  EXPECT_NEAR(biases.suspected_m(), 0.0, 1e-6);
}

TEST(RangeBiasesTest, RangesThatAreAMetreLongAreLearnedWithinTwoHundredMetres) {
  for (const double true_m : {1.0, -1.0, 0.7}) {
    RangeBiases biases(2, {});
    Drive(0.0).Go(biases, 300);
    EXPECT_GE(Drive(true_m).Go(biases, 130), 1) << true_m;
    ASSERT_TRUE(biases.bias_m(0)) << true_m;
    EXPECT_NEAR(biases.bias_m(0)->value, true_m, 0.12) << true_m;
    EXPECT_FALSE(biases.bias_m(1)) << "the other radar's are right";
  }
}

TEST(RangeBiasesTest, WhatIsLittleMayBeTheMaps) {
  RangeBiases biases(1, {});
  EXPECT_EQ(Drive(0.3).Go(biases, 1000), 0);
}

TEST(RangeBiasesTest, AStandingVehicleSeesTheSameAgainAndLearnsNothing) {
  RangeBiases biases(1, {});
  EXPECT_EQ(Drive(1.0).Go(biases, 1000, 0.0), 0);
}

TEST(RangeBiasesTest, APoseMayBeOffByWhatItAbsorbsUntilTheBiasIsKnown) {
  RangeBiases biases(2, {});
  Drive(0.0).Go(biases, 300);
  Drive(1.0).Go(biases, 20);
  EXPECT_GE(biases.suspected_m(), 0.5 * Drive::kAbsorbed_m) << "of one radar of two";
  Drive(1.0).Go(biases, 300);
  EXPECT_LT(biases.suspected_m(), 0.06);
}

TEST(RangeBiasesTest, WhereNothingFitsWhatWasLearnedAndWhatIsDescribedAreTriedInTurn) {
  RangeBiases biases(2, {});
  EXPECT_FALSE(biases.TryOther());
  biases.Restore(0, {0.7, 1e-9});
  EXPECT_GT(biases.bias_m(0)->variance, 1e-4) << "no bias is known so well";
  EXPECT_TRUE(biases.TryOther());
  EXPECT_FALSE(biases.bias_m(0));
  EXPECT_TRUE(biases.TryOther());
  EXPECT_EQ(biases.bias_m(0)->value, 0.7);
}

TEST(RangeBiasesTest, ABiasThatWasSeenForLongIsNotDoubtedWithThePlace) {
  RangeBiases biases(2, {});
  Drive(1.0).Go(biases, 130);
  Drive(1.0).Go(biases, 130);
  ASSERT_TRUE(biases.bias_m(0));
  biases.Reset();
  EXPECT_FALSE(biases.TryOther());
  EXPECT_NEAR(biases.bias_m(0)->value, 1.0, 0.12);
}

TEST(RangeBiasesTest, WhereNoPlaceWasEverFoundAllRadarsAreGuessedToBeOffAlike) {
  RangeBiases biases(2, {});
  ASSERT_TRUE(biases.KnowsNothing());
  for (const double sign : {1.0, -1.0, 0.0, 1.0}) {
    biases.Guess();
    EXPECT_TRUE(biases.KnowsNothing());
    for (const std::size_t i : {0U, 1U}) {
      EXPECT_EQ(biases.bias_m(i).has_value(), sign != 0.0);
      if (biases.bias_m(i)) {
        EXPECT_EQ(biases.bias_m(i)->value, sign * biases.options().guess_m);
      }
    }
  }
  Drive(0.5).Go(biases, 2);
  EXPECT_FALSE(biases.KnowsNothing()) << "it was held against a place";
}

TEST(RangeBiasesTest, WhatAnEarlierSessionFoundIsNoGuess) {
  RangeBiases biases(2, {});
  biases.Restore(0, {0.7, 1e-9});
  EXPECT_FALSE(biases.KnowsNothing());
}

TEST(RangeBiasesTest, NoBiasIsLargerThanItsBound) {
  RangeBiases biases(1, {});
  biases.Restore(0, {1e9, 1.0});
  EXPECT_EQ(biases.bias_m(0)->value, biases.options().max_bias_m);
  Drive(5.0).Go(biases, 1000);
  EXPECT_LE(std::abs(biases.bias_m(0)->value), biases.options().max_bias_m);
}

std::vector<GaussianPoint<2>> PointsBetween(double min_rad, double max_rad) {
  constexpr int kCount = 40;
  std::vector<GaussianPoint<2>> points;
  for (int i = 0; i <= kCount; ++i) {
    const double azimuth_rad = min_rad + (max_rad - min_rad) * i / kCount;
    const double range_m = 20.0 + i % 7;
    points.push_back(
        {.mean_m = range_m * Eigen::Vector2d(std::cos(azimuth_rad), std::sin(azimuth_rad)),
         .covariance_m2 = 0.01 * Eigen::Matrix2d::Identity()});
  }
  return points;
}

TEST(ShiftsByRangeTest, AMotionDoesMostOfItWhereAllIsAheadAndNothingWhereItIsAllAround) {
  std::vector<Eigen::Vector2d> shifts_m;
  const auto ahead = PointsBetween(-0.4, 0.4);
  const double absorbed_m = ShiftsByRange<2>(ahead, Eigen::Vector2d::Zero(), 0.2, shifts_m);
  EXPECT_NEAR(absorbed_m, 0.95, 0.05);
  ASSERT_EQ(shifts_m.size(), ahead.size());
  EXPECT_LT(shifts_m.front().y(), -0.3) << "to the right, on the right";
  EXPECT_GT(shifts_m.back().y(), 0.3);
  EXPECT_LT(shifts_m[ahead.size() / 2].norm(), 0.1);

  const auto around = PointsBetween(-3.1, 3.1);
  EXPECT_LT(ShiftsByRange<2>(around, Eigen::Vector2d::Zero(), 0.2, shifts_m), 0.05);
  for (const Eigen::Vector2d& shift_m : shifts_m) EXPECT_NEAR(shift_m.norm(), 1.0, 0.1);
}

}  // namespace
}  // namespace dcloc
