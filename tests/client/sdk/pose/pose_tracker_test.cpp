#include "client/sdk/pose/pose_tracker.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "tests/client/sdk/pose/answers.h"

namespace dcloc::client {
namespace {

using ::testing::HasSubstr;

PoseEstimate Pose(const PoseTracker& poses, std::int64_t milliseconds) {
  const absl::StatusOr<PoseEstimate> estimate = poses.PoseAt(At(milliseconds));
  EXPECT_TRUE(estimate.ok()) << estimate.status();
  return estimate.value_or(PoseEstimate{});
}

double X(const PoseTracker& poses, std::int64_t milliseconds) {
  return Pose(poses, milliseconds).T_map_vehicle.translation_m[0];
}

double SigmaX(const PoseEstimate& estimate) { return std::sqrt(estimate.covariance[0]); }

TEST(PoseTrackerTest, WithoutAnAnswerThereIsNone) {
  PoseTracker poses({});
  EXPECT_EQ(poses.PoseAt(At(0)).status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_TRUE(poses.AddVelocity(At(0), Driving(10.0)).ok());
  EXPECT_EQ(poses.PoseAt(At(0)).status().code(), absl::StatusCode::kFailedPrecondition);
}

TEST(PoseTrackerTest, AnAnswerWithoutAPoseEndsWhatWasKnown) {
  PoseTracker poses({});
  poses.AddAnswer(AnswerAt(0, 5.0));
  EXPECT_TRUE(poses.PoseAt(At(0)).ok());
  v1::LocalizationResult initializing = AnswerAt(100, 6.0);
  initializing.set_state(v1::LOCALIZATION_STATE_INITIALIZING);
  poses.AddAnswer(initializing);
  EXPECT_EQ(poses.PoseAt(At(100)).status().code(), absl::StatusCode::kFailedPrecondition);
}

TEST(PoseTrackerTest, AtAnAnswersStampItIsTheAnswer) {
  PoseTracker poses({});
  ASSERT_TRUE(poses.AddVelocity(At(0), Driving(20.0)).ok());
  poses.AddAnswer(AnswerAt(0, 5.0));
  poses.AddAnswer(AnswerAt(100, 7.3));
  EXPECT_NEAR(X(poses, 0), 5.0, 1e-9);
  EXPECT_NEAR(X(poses, 100), 7.3, 1e-9);
  const PoseEstimate estimate = Pose(poses, 100);
  EXPECT_NEAR(estimate.covariance[0], 0.01, 1e-12);
  EXPECT_EQ(estimate.state, v1::LOCALIZATION_STATE_TRACKING);
  EXPECT_EQ(estimate.answer_stamp_ns, At(100));
}

TEST(PoseTrackerTest, AfterTheLastAnswerTheVehiclesOwnMotionGoesOn) {
  PoseTracker poses({});
  poses.AddAnswer(AnswerAt(0, 0.0));
  constexpr double kRadius_m = 40.0;
  for (int ms = 0; ms <= 200; ms += 20) {
    ASSERT_TRUE(poses.AddVelocity(At(ms), Driving(20.0, 20.0 / kRadius_m)).ok());
  }
  const PoseEstimate estimate = Pose(poses, 300);  // 6 m along a circle
  const double angle_rad = 6.0 / kRadius_m;
  EXPECT_NEAR(estimate.T_map_vehicle.translation_m[0], kRadius_m * std::sin(angle_rad), 1e-9);
  EXPECT_NEAR(estimate.T_map_vehicle.translation_m[1], kRadius_m * (1 - std::cos(angle_rad)), 1e-9);
  EXPECT_NEAR(2.0 * std::asin(estimate.T_map_vehicle.rotation_wxyz[3]), angle_rad, 1e-9);
  EXPECT_NEAR(estimate.velocity[0], 20.0, 1e-9);
  EXPECT_NEAR(estimate.velocity[5], 0.5, 1e-9);
}

TEST(PoseTrackerTest, BrakingIsFollowedBetweenVelocities) {
  PoseTracker poses({});
  poses.AddAnswer(AnswerAt(0, 0.0));
  ASSERT_TRUE(poses.AddVelocity(At(0), Driving(20.0)).ok());
  ASSERT_TRUE(poses.AddVelocity(At(200), Driving(18.0)).ok());
  EXPECT_NEAR(X(poses, 100), 1.95, 1e-9);
  EXPECT_NEAR(Pose(poses, 100).velocity[0], 19.0, 1e-9);
  EXPECT_NEAR(X(poses, 200), 3.8, 1e-9);
}

TEST(PoseTrackerTest, WithoutVelocitiesTheAnswersSayHowItMoves) {
  PoseTracker poses({});
  for (int ms = 0; ms <= 400; ms += 100) poses.AddAnswer(AnswerAt(ms, 0.02 * ms));
  EXPECT_NEAR(X(poses, 350), 7.0, 1e-9);
  EXPECT_NEAR(X(poses, 500), 10.0, 1e-9);
  EXPECT_NEAR(Pose(poses, 500).velocity[0], 20.0, 1e-9);
  EXPECT_NEAR(Pose(poses, 350).velocity[0], 20.0, 1e-9);
}

TEST(PoseTrackerTest, AnIsolatedAnswerSaysThatItMayBeAnywhereSoon) {
  PoseTracker poses({});
  poses.AddAnswer(AnswerAt(0, 0.0));
  EXPECT_NEAR(SigmaX(Pose(poses, 0)), 0.1, 1e-9);
  EXPECT_GT(SigmaX(Pose(poses, 100)), 1.0);
}

TEST(PoseTrackerTest, VelocitiesThatTheServerFindsFaultyAreNotUsed) {
  PoseTracker poses({});
  for (int ms = 0; ms <= 400; ms += 100) {
    ASSERT_TRUE(poses.AddVelocity(At(ms), Driving(40.0)).ok());
    v1::LocalizationResult answer = AnswerAt(ms, 0.02 * ms);
    answer.mutable_health()->mutable_wheel_speed()->set_fault(v1::SOURCE_FAULT_SCALE);
    poses.AddAnswer(answer);
  }
  EXPECT_NEAR(X(poses, 500), 10.0, 1e-9);
}

TEST(PoseTrackerTest, VelocitiesThatHaveStoppedComingAreNotUsed) {
  PoseTracker poses({});
  ASSERT_TRUE(poses.AddVelocity(At(0), Driving(40.0)).ok());
  for (int ms = 0; ms <= 400; ms += 100) poses.AddAnswer(AnswerAt(ms, 0.02 * ms));
  EXPECT_NEAR(X(poses, 500), 10.0, 1e-9);
}

TEST(PoseTrackerTest, TheCovarianceGrowsAfterTheLastAnswer) {
  PoseTracker poses({});
  poses.AddAnswer(AnswerAt(0, 0.0));
  ASSERT_TRUE(poses.AddVelocity(At(0), Driving(20.0)).ok());
  double before = 0.0;
  for (int ms = 0; ms <= 500; ms += 50) {
    const double sigma = SigmaX(Pose(poses, ms));
    EXPECT_GT(sigma, before);
    before = sigma;
  }
  EXPECT_GT(before, 0.15);
  EXPECT_LT(before, 0.5);
}

TEST(PoseTrackerTest, ItIsRefusedTooFarAheadAndTooFarBack) {
  PoseTracker poses({});
  ASSERT_TRUE(poses.AddVelocity(At(0), Driving(20.0)).ok());
  for (int ms = 0; ms <= 2000; ms += 50) poses.AddAnswer(AnswerAt(ms, 0.0));
  EXPECT_TRUE(poses.PoseAt(At(2500)).ok());
  const absl::Status late = poses.PoseAt(At(2501)).status();
  EXPECT_EQ(late.code(), absl::StatusCode::kOutOfRange);
  EXPECT_THAT(std::string(late.message()), HasSubstr("max_ahead"));
  EXPECT_TRUE(poses.PoseAt(At(1500)).ok());
  const absl::Status early = poses.PoseAt(At(1000)).status();
  EXPECT_EQ(early.code(), absl::StatusCode::kOutOfRange);
  EXPECT_THAT(std::string(early.message()), HasSubstr("begins at"));
}

TEST(PoseTrackerTest, AJumpIsNotTakenForMotion) {
  PoseTracker poses({});
  for (int ms = 0; ms <= 300; ms += 100) poses.AddAnswer(AnswerAt(ms, 0.01 * ms));
  v1::LocalizationResult jumped = AnswerAt(400, 104.0);
  jumped.mutable_resets()->set_count(1);
  poses.AddAnswer(jumped);
  EXPECT_NEAR(X(poses, 300), 3.0, 1e-9);
  EXPECT_LT(X(poses, 399), 5.0);
  EXPECT_NEAR(X(poses, 400), 104.0, 1e-9);
  EXPECT_NEAR(X(poses, 450), 104.0, 1e-9);  // nothing is known of its motion yet
}

TEST(PoseTrackerTest, AnswersMayComeLateAndTwice) {
  PoseTracker poses({});
  ASSERT_TRUE(poses.AddVelocity(At(0), Driving(20.0)).ok());
  poses.AddAnswer(AnswerAt(0, 0.0));
  poses.AddAnswer(AnswerAt(200, 4.0));
  poses.AddAnswer(AnswerAt(100, 2.4));
  poses.AddAnswer(AnswerAt(100, 2.2));
  EXPECT_NEAR(X(poses, 100), 2.2, 1e-9);
  EXPECT_NEAR(X(poses, 300), 6.0, 1e-9);
}

TEST(PoseTrackerTest, AClockThatIsSetBackStartsOver) {
  PoseTracker poses({});
  ASSERT_TRUE(poses.AddVelocity(At(10'000), Driving(20.0)).ok());
  poses.AddAnswer(AnswerAt(10'000, 50.0));
  poses.AddAnswer(AnswerAt(1000, 52.0));
  EXPECT_NEAR(X(poses, 1000), 52.0, 1e-9);
  EXPECT_FALSE(poses.PoseAt(At(10'000)).ok());
}

TEST(PoseTrackerTest, AVelocityThatComesLateDoesNoHarm) {
  PoseTracker poses({});
  poses.AddAnswer(AnswerAt(10'000, 50.0));
  ASSERT_TRUE(poses.AddVelocity(At(10'000), Driving(20.0)).ok());
  ASSERT_TRUE(poses.AddVelocity(At(10), Driving(5.0)).ok());
  EXPECT_NEAR(X(poses, 10'100), 52.0, 1e-9);
}

TEST(PoseTrackerTest, VelocitiesMayComeAtAKilohertz) {
  PoseTracker poses({});
  poses.AddAnswer(AnswerAt(0, 0.0));
  for (int ms = 0; ms <= 450; ++ms) {
    ASSERT_TRUE(poses.AddVelocity(At(ms), Driving(0.04 * ms)).ok());  // 40 m/s^2
  }
  EXPECT_NEAR(X(poses, 450), 0.5 * 40.0 * 0.45 * 0.45, 1e-3);
}

TEST(PoseTrackerTest, AVelocityThatCannotBeIsRefused) {
  PoseTracker poses({});
  EXPECT_EQ(poses.AddVelocity(0, Driving(1.0)).code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(poses.AddVelocity(At(0), Driving(std::numeric_limits<double>::infinity())).code(),
            absl::StatusCode::kInvalidArgument);
  v1::EgoVelocity velocity = Driving(1.0);
  velocity.add_covariance(1.0);
  EXPECT_THAT(std::string(poses.AddVelocity(At(0), velocity).message()), HasSubstr("36"));
}

TEST(PoseTrackerTest, WhatTheServerHasLearnedOfTheOdometryIsUsed) {
  PoseTracker poses({});
  ASSERT_TRUE(poses.AddVelocity(At(0), Driving(20.0)).ok());
  v1::LocalizationResult answer = AnswerAt(0, 0.0);
  answer.mutable_learned_rig()->mutable_wheel_scale()->set_value(1.02);
  answer.mutable_learned_rig()->mutable_yaw_rate_correction_radps()->set_value(0.1);
  poses.AddAnswer(answer);
  const auto pose = poses.PoseAt(At(100));
  ASSERT_TRUE(pose.ok()) << pose.status();
  EXPECT_NEAR(pose->velocity[0], 20.4, 1e-9);
  EXPECT_NEAR(pose->velocity[5], 0.1, 1e-9);
  EXPECT_NEAR(pose->T_map_vehicle.translation_m[0], 2.04, 1e-3);
  // Answers without it, as most are, change nothing of it.
  poses.AddAnswer(AnswerAt(50, 1.02));
  EXPECT_NEAR(poses.PoseAt(At(100))->velocity[0], 20.4, 1e-9);
}

TEST(PoseTrackerTest, OnceTheScaleIsLearnedTheMotionIsAsSureAsThat) {
  const auto added_m2 = [](const v1::LocalizationResult& answer) {
    PoseTracker poses({.velocity_sigma_mps = 0.01, .velocity_scale_sigma = 0.005});
    EXPECT_TRUE(poses.AddVelocity(At(0), Driving(20.0)).ok());
    EXPECT_TRUE(poses.AddVelocity(At(100), Driving(20.0)).ok());
    poses.AddAnswer(answer);
    return Pose(poses, 100).covariance[0] - Pose(poses, 0).covariance[0];
  };
  v1::LocalizationResult answer = AnswerAt(0, 0.0);
  EXPECT_NEAR(added_m2(answer), 0.01 * (1e-4 + 0.01), 1e-9);
  answer.mutable_learned_rig()->mutable_wheel_scale()->set_value(1.0);
  answer.mutable_learned_rig()->mutable_wheel_scale()->set_sigma(0.002);
  EXPECT_NEAR(added_m2(answer), 0.01 * (1e-4 + 0.0016), 1e-9);
}

TEST(PoseTrackerTest, OnceErrorsAreLearnedTheRestAveragesOutOverReadings) {
  PoseTracker poses({.velocity_sigma_mps = 0.03, .turn_rate_sigma_radps = 0.002});
  for (int ms = 0; ms <= 100; ms += 20) {
    ASSERT_TRUE(poses.AddVelocity(At(ms), Driving(20.0)).ok());
  }
  v1::LocalizationResult answer = AnswerAt(0, 0.0);
  answer.mutable_learned_rig()->mutable_wheel_scale()->set_value(1.0);
  answer.mutable_learned_rig()->mutable_wheel_scale()->set_sigma(0.001);
  answer.mutable_learned_rig()->mutable_yaw_rate_correction_radps()->set_sigma(0.0005);
  poses.AddAnswer(answer);
  const Matrix6 end = Pose(poses, 100).covariance;
  const Matrix6 begin = Pose(poses, 0).covariance;
  EXPECT_NEAR(end[0] - begin[0], 0.01 * 0.0004 + 0.1 * 0.02 * 9e-4, 1e-9);
  EXPECT_NEAR(end[35] - begin[35], 0.01 * 2.5e-7 + 0.1 * 0.02 * 4e-6, 1e-12);
}

TEST(PoseTrackerTest, AVelocitysOwnCovarianceCountsWhateverWasLearned) {
  PoseTracker poses({});
  v1::EgoVelocity velocity = Driving(20.0);
  for (int i = 0; i < 36; ++i) velocity.add_covariance(i == 0 ? 0.09 : 0.0);
  ASSERT_TRUE(poses.AddVelocity(At(0), velocity).ok());
  ASSERT_TRUE(poses.AddVelocity(At(100), velocity).ok());
  v1::LocalizationResult answer = AnswerAt(0, 0.0);
  answer.mutable_learned_rig()->mutable_wheel_scale()->set_value(1.0);
  answer.mutable_learned_rig()->mutable_wheel_scale()->set_sigma(0.002);
  poses.AddAnswer(answer);
  EXPECT_NEAR(Pose(poses, 100).covariance[0] - Pose(poses, 0).covariance[0], 0.01 * 0.09, 1e-9);
}

TEST(PoseTrackerTest, AnswersAloneSayLittleOfTheSpeedButMuchOfTheWayAside) {
  PoseTracker poses({});
  for (int i = 0; i <= 300; i += 100) poses.AddAnswer(AnswerAt(i, 0.02 * i));
  const PoseEstimate estimate = Pose(poses, 400);
  EXPECT_LT(estimate.covariance[7], estimate.covariance[0]);
}

}  // namespace
}  // namespace dcloc::client
