#include "client/ros/fix_messages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "client/rosbag/message_reader.h"
#include "tests/client/ros/messages.h"

namespace dcloc::node {
namespace {

using ::testing::HasSubstr;

TEST(FixMessagesTest, AReceiverWithoutDeviationsGetsThem) {
  const auto message = rosbag::ParseSatelliteFix(SatelliteFixAt(At(5), true).data);
  ASSERT_TRUE(message.ok()) << message.status();
  const auto fix = FixOf(*message, 4.0);
  ASSERT_TRUE(fix.ok()) << fix.status();
  EXPECT_EQ(fix->stamp_ns(), At(5).time_since_epoch().count());
  EXPECT_EQ(fix->gnss_fix().position().latitude_deg(), 48.1);
  EXPECT_EQ(fix->gnss_fix().horizontal_sigma_m(), 4.0);
  EXPECT_EQ(fix->gnss_fix().vertical_sigma_m(), 8.0);
  rosbag::SatelliteFix precise = *message;
  precise.horizontal_sigma_m = 0.02;
  EXPECT_EQ(FixOf(precise, 4.0)->gnss_fix().horizontal_sigma_m(), 0.02);
  precise.has_fix = false;
  EXPECT_EQ(FixOf(precise, 4.0).status().code(), absl::StatusCode::kFailedPrecondition);
}

TEST(FixMessagesTest, APoseOfRvizKeepsItsCovarianceAndIsCertainInNothing) {
  const Sent sent = InitialPoseAt(At(5), 12.0);
  const auto message = rosbag::ParseMotion(sent.connection.type, sent.data);
  ASSERT_TRUE(message.ok()) << message.status();
  const auto pose = PoseOf(*message, "map");
  ASSERT_TRUE(pose.ok()) << pose.status();
  EXPECT_EQ(pose->pose().translation_m().x(), 12.0);
  EXPECT_EQ(pose->pose().rotation().w(), 1.0);
  ASSERT_EQ(pose->covariance_size(), 36);
  EXPECT_EQ(pose->covariance(0), 0.25);
  EXPECT_EQ(pose->covariance(35), 0.07);
  EXPECT_EQ(pose->covariance(14), 0.01) << "a height of 0 that nobody has measured";
}

TEST(FixMessagesTest, APoseInAnotherFrameOrNoneIsRefused) {
  const Sent sent = InitialPoseAt(At(5), 12.0, "odom");
  auto message = *rosbag::ParseMotion(sent.connection.type, sent.data);
  EXPECT_THAT(std::string(PoseOf(message, "map").status().message()),
              HasSubstr("its frame is odom; it must be map"));
  message.header.frame_id = "map";
  message.T_frame_child->rotation.coeffs().setZero();
  EXPECT_EQ(PoseOf(message, "map").status().code(), absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace dcloc::node
