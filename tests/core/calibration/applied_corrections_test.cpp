#include "core/calibration/applied_corrections.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dcloc {
namespace {

constexpr auto kKind = static_cast<std::size_t>(CalibrationParameter::kTimeOffset);

// Time offsets whose errors are one of `common_sigma` and one of each radar's own of `own_sigma`,
// where 1 was known before; of all else nothing is known.
Calibration TimeOffsets(const Eigen::VectorXd& corrections, double common_sigma, double own_sigma) {
  const Eigen::Index count = corrections.size();
  Calibration calibration;
  calibration.covariance =
      Eigen::MatrixXd::Identity(count * kCalibrationParameters, count * kCalibrationParameters);
  const auto at = [](Eigen::Index radar) {
    return radar * kCalibrationParameters + static_cast<Eigen::Index>(kKind);
  };
  for (Eigen::Index i = 0; i < count; ++i) {
    RadarCalibration radar{.described = {}, .parameters = {}};
    for (CalibratedParameter& value : radar.parameters) value = {.sigma = 1.0, .prior_sigma = 1.0};
    radar.parameters.at(kKind) = {.correction = corrections(i),
                                  .sigma = std::hypot(common_sigma, own_sigma),
                                  .prior_sigma = 1.0};
    calibration.radars.push_back(radar);
    for (Eigen::Index j = 0; j < count; ++j) {
      calibration.covariance(at(i), at(j)) =
          common_sigma * common_sigma + (i == j ? own_sigma * own_sigma : 0.0);
    }
  }
  return calibration;
}

Eigen::VectorXd Applied(Calibration calibration, bool poses_are_own = false) {
  ChooseApplied(calibration, poses_are_own);
  Eigen::VectorXd applied(static_cast<Eigen::Index>(calibration.radars.size()));
  for (Eigen::Index i = 0; i < applied.size(); ++i) {
    applied(i) = calibration.radars[static_cast<std::size_t>(i)].parameters.at(kKind).applied;
  }
  return applied;
}

const Eigen::Vector3d kOffsets(0.5, 0.7, 0.9);  // 0.7 in common, -0.2, 0 and 0.2 their own

TEST(ChooseAppliedTest, TakesAllThatIsKnown) {
  EXPECT_LT((Applied(TimeOffsets(kOffsets, 0.1, 0.1)) - kOffsets).norm(), 1e-12);
}

TEST(ChooseAppliedTest, TakesDifferencesWhereOnlyTheyAreKnown) {
  const Eigen::VectorXd applied = Applied(TimeOffsets(kOffsets, 0.6, 0.1));
  EXPECT_LT((applied - Eigen::Vector3d(-0.2, 0.0, 0.2)).norm(), 1e-12);
}

TEST(ChooseAppliedTest, TakesTheMeanWhereDifferencesAreNoise) {
  const Eigen::VectorXd applied = Applied(TimeOffsets(kOffsets, 0.1, 0.3));
  EXPECT_LT((applied - Eigen::Vector3d::Constant(0.7)).norm(), 1e-12);
}

TEST(ChooseAppliedTest, TakesWhatIsHardlyDeterminedOnlyWhereItIsSignificant) {
  const auto one = [](double correction) {
    return Applied(TimeOffsets(Eigen::VectorXd::Constant(1, correction), 0.6, 0.0))(0);
  };
  EXPECT_EQ(one(1.1), 0.0);
  EXPECT_EQ(one(1.2), 1.2);
}

// A correction of one sigma is as likely to harm as to help.
TEST(ChooseAppliedTest, TakesWhatPromisesSmallerErrors) {
  const auto one = [](double correction) {
    return Applied(TimeOffsets(Eigen::VectorXd::Constant(1, correction), 0.1, 0.0))(0);
  };
  EXPECT_EQ(one(0.1), 0.0);
  EXPECT_EQ(one(0.14), 0.0);
  EXPECT_EQ(one(0.15), 0.15);
  EXPECT_EQ(one(-0.15), -0.15);
}

TEST(ChooseAppliedTest, CountsWhatIsLeftOutAmongTheErrorsThatStay) {
  Calibration calibration = TimeOffsets(kOffsets, 0.6, 0.1);
  ChooseApplied(calibration);
  const CalibratedParameter& last = calibration.radars[2].parameters.at(kKind);
  EXPECT_NEAR(last.remaining_sigma, std::hypot(last.sigma, 0.7), 1e-12);
  EXPECT_EQ(calibration.radars[2].of(CalibrationParameter::kMountYaw).remaining_sigma, 1.0);
}

// Poses that the radars made themselves lie where they were, whatever their clocks said.
TEST(ChooseAppliedTest, LeavesTheMeanOfClocksToPosesThatTheyMade) {
  const Eigen::VectorXd applied = Applied(TimeOffsets(kOffsets, 0.05, 0.05), true);
  EXPECT_LT((applied - Eigen::Vector3d(-0.2, 0.0, 0.2)).norm(), 1e-12);
}

TEST(ChooseAppliedTest, OwnPosesAreBelievedOnlyWhatIsSignificant) {
  const Eigen::Vector3d offsets(-0.15, 0.0, 0.15);
  EXPECT_LT((Applied(TimeOffsets(offsets, 0.0, 0.09)) - offsets).norm(), 1e-12);
  EXPECT_EQ(Applied(TimeOffsets(offsets, 0.0, 0.09), true).norm(), 0.0);
  EXPECT_LT((Applied(TimeOffsets(offsets, 0.0, 0.05), true) - offsets).norm(), 1e-12);
}

}  // namespace
}  // namespace dcloc
