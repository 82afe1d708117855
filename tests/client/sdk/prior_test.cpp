#include "client/sdk/prior.h"

#include <gtest/gtest.h>

namespace dcloc::client {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

v1::LocalizationResult StampedAnswer(
    std::int64_t stamp_ns, double x_m,
    v1::LocalizationState state = v1::LOCALIZATION_STATE_TRACKING) {
  v1::LocalizationResult result;
  result.set_stamp_ns(stamp_ns);
  result.set_state(state);
  result.mutable_pose()->mutable_pose()->mutable_translation_m()->set_x(x_m);
  for (int i = 0; i < 36; ++i) result.mutable_pose()->add_covariance(i % 7 == 0 ? 0.01 : 0.0);
  return result;
}

TEST(PriorTest, WithoutAnAnswerTheClientsOwnStartStays) {
  v1::OpenSession open;
  open.mutable_initial_pose()->add_covariance(1.0);
  Prior().Apply(kSecond_ns, &open);
  EXPECT_EQ(open.initial_pose().covariance_size(), 1);
}

TEST(PriorTest, TheLastPoseIsWidenedByHowFarTheVehicleMayHaveCome) {
  Prior prior;
  prior.Note(StampedAnswer(1 * kSecond_ns, 0.0));
  prior.Note(StampedAnswer(2 * kSecond_ns, 15.0));
  v1::OpenSession open;
  prior.Apply(4 * kSecond_ns, &open);
  const v1::PoseWithCovariance& pose = open.initial_pose();
  EXPECT_EQ(pose.pose().translation_m().x(), 15.0);
  EXPECT_NEAR(pose.covariance(0), 0.01 + 900.0, 1e-9);  // two seconds at 15 m/s
  EXPECT_NEAR(pose.covariance(7), 0.01 + 900.0, 1e-9);
  EXPECT_EQ(pose.covariance(14), 0.01);
  EXPECT_EQ(pose.covariance(35), 0.01);
  v1::OpenSession earlier;
  prior.Apply(1 * kSecond_ns, &earlier);
  EXPECT_EQ(earlier.initial_pose().covariance(0), 0.01);
}

TEST(PriorTest, AStampThatGoesBackChangesNoSpeed) {
  Prior prior;
  prior.Note(StampedAnswer(1 * kSecond_ns, 0.0));
  prior.Note(StampedAnswer(2 * kSecond_ns, 10.0));
  prior.Note(StampedAnswer(2 * kSecond_ns, 500.0));
  v1::OpenSession open;
  prior.Apply(3 * kSecond_ns, &open);
  EXPECT_NEAR(open.initial_pose().covariance(0), 0.01 + 100.0, 1e-9);
}

TEST(PriorTest, WhereThePlaceIsNotKnownNoneIsClaimed) {
  Prior prior;
  prior.Note(StampedAnswer(1 * kSecond_ns, 0.0));
  prior.Note(StampedAnswer(2 * kSecond_ns, 1.0, v1::LOCALIZATION_STATE_INITIALIZING));
  v1::OpenSession open;
  open.mutable_initial_pose();
  prior.Apply(3 * kSecond_ns, &open);
  EXPECT_FALSE(open.has_initial_pose());
  prior.Note(StampedAnswer(3 * kSecond_ns, 2.0, v1::LOCALIZATION_STATE_LOST));
  prior.Apply(3 * kSecond_ns, &open);
  EXPECT_TRUE(open.has_initial_pose());
}

}  // namespace
}  // namespace dcloc::client
