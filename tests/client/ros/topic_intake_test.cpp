#include "client/ros/topic_intake.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/client/ros/messages.h"

namespace dcloc::node {
namespace {

using std::chrono::milliseconds;
using ::testing::AllOf;
using ::testing::HasSubstr;

BagMapping OneRadar() {
  BagMapping mapping;
  RadarMapping& radar = mapping.radars.emplace_back();
  radar.id = "front";
  radar.topic = "/front";
  radar.range = "range";
  radar.azimuth = "azimuth";
  radar.range_rate = "range_rate";
  mapping.motion_topic = "/velocity";
  return mapping;
}

class TopicIntakeTest : public ::testing::Test {
 protected:
  absl::Status Take(const Sent& sent) { return intake_.Take(sent.message(), now_); }
  std::vector<Scan> Ready() { return intake_.TakeReady(rig_, now_); }
  void Describe() { ASSERT_TRUE(intake_.DescribeRadars(rig_).ok()); }

  TopicIntake intake_{OneRadar(), milliseconds(50)};
  TopicIntake::Time now_{std::chrono::seconds(100)};
  Rig rig_{{{.id = "front"}}};
};

TEST_F(TopicIntakeTest, AScanWaitsForTheVelocityAfterItAndGetsWhatLiesBetween) {
  ASSERT_TRUE(Take(VelocityAt(At(0), 10.0)).ok());
  ASSERT_TRUE(Take(CloudAt(At(5))).ok());
  EXPECT_TRUE(Ready().empty());
  ASSERT_TRUE(Take(VelocityAt(At(20), 14.0)).ok());
  const std::vector<Scan> scans = Ready();
  ASSERT_EQ(scans.size(), 1U);
  EXPECT_EQ(scans[0].stamp, At(5));
  EXPECT_EQ(scans[0].range_m, std::vector<float>({10.0F, 11.0F, 12.0F}));
  ASSERT_TRUE(scans[0].ego_velocity.has_value());
  EXPECT_EQ(scans[0].ego_velocity->linear_mps.x(), 11.0);
  EXPECT_TRUE(Ready().empty()) << "it is given once";
}

TEST_F(TopicIntakeTest, AVelocityOfTheVeryStampIsTakenAsItIs) {
  ASSERT_TRUE(Take(CloudAt(At(5))).ok());
  EXPECT_TRUE(Ready().empty());
  ASSERT_TRUE(Take(VelocityAt(At(5), 10.1)).ok());
  ASSERT_EQ(Ready().at(0).ego_velocity->linear_mps.x(), 10.1);
}

TEST_F(TopicIntakeTest, WithoutWheelsAScanWaitsNoLongerThanItMay) {
  ASSERT_TRUE(Take(CloudAt(At(5))).ok());
  now_ += milliseconds(49);
  EXPECT_TRUE(Ready().empty());
  now_ += milliseconds(1);
  const std::vector<Scan> scans = Ready();
  ASSERT_EQ(scans.size(), 1U);
  EXPECT_FALSE(scans[0].ego_velocity.has_value());
}

TEST_F(TopicIntakeTest, ScansLeaveByStamp) {
  ASSERT_TRUE(Take(CloudAt(At(30))).ok());
  ASSERT_TRUE(Take(CloudAt(At(10))).ok());
  ASSERT_TRUE(Take(VelocityAt(At(40), 10.0)).ok());
  const std::vector<Scan> scans = Ready();
  ASSERT_EQ(scans.size(), 2U);
  EXPECT_EQ(scans[0].stamp, At(10));
}

TEST_F(TopicIntakeTest, MountsComeFromTf) {
  Rig rig;
  EXPECT_THAT(std::string(intake_.DescribeRadars(rig).message()), HasSubstr("no message of topic"));
  ASSERT_TRUE(Take(CloudAt(At(5))).ok());
  EXPECT_THAT(std::string(intake_.DescribeRadars(rig).message()), HasSubstr("front_radar"));
  EXPECT_TRUE(rig.radars.empty());
  ASSERT_TRUE(Take(Mount()).ok());
  ASSERT_TRUE(intake_.DescribeRadars(rig).ok());
  ASSERT_EQ(rig.radars.size(), 1U);
  EXPECT_EQ(rig.radars[0].T_vehicle_radar.translation_m.x(), 3.5);
}

TEST_F(TopicIntakeTest, WrongTypesAndFieldsAreNamedAndCounted) {
  const absl::Status field = Take(CloudAt(At(5), "/front", 3, "doppler"));
  EXPECT_THAT(
      std::string(field.message()),
      AllOf(HasSubstr("topic /front"), HasSubstr("no field \"range_rate\""), HasSubstr("doppler")));
  Sent odometry = VelocityAt(At(5), 1.0);
  odometry.connection.topic = "/front";
  EXPECT_THAT(std::string(Take(odometry).message()), HasSubstr("sensor_msgs/PointCloud2"));
  Sent other = CloudAt(At(5));
  other.connection.md5sum = "0";
  EXPECT_THAT(std::string(Take(other).message()), HasSubstr("another sensor_msgs/PointCloud2"));
  EXPECT_EQ(intake_.topics().at("/front").error_count, 3);
  EXPECT_FALSE(intake_.topics().at("/front").error.empty());
  ASSERT_TRUE(Take(CloudAt(At(5))).ok());
  EXPECT_TRUE(intake_.topics().at("/front").error.empty());
}

TEST_F(TopicIntakeTest, AClockThatIsSetBackBeginsAnew) {
  ASSERT_TRUE(Take(VelocityAt(At(10'000), 10.0)).ok());
  ASSERT_TRUE(Take(CloudAt(At(10'010))).ok());
  ASSERT_TRUE(Take(VelocityAt(At(0), 12.0)).ok());
  ASSERT_TRUE(Take(CloudAt(At(0))).ok());
  const std::vector<Scan> scans = Ready();
  ASSERT_EQ(scans.size(), 1U);
  EXPECT_EQ(scans[0].stamp, At(0));
  EXPECT_EQ(scans[0].ego_velocity->linear_mps.x(), 12.0);
  EXPECT_EQ(intake_.clock_jump_count(), 2);
  EXPECT_EQ(intake_.dropped_count(), 1);
}

TEST_F(TopicIntakeTest, OdometryTellsWhereTheVehicleIsInItsOwnFrame) {
  ASSERT_TRUE(Take(OdometryAt(At(0), 5.0, 20.0)).ok());
  ASSERT_TRUE(Take(OdometryAt(At(100), 7.0, 20.0)).ok());
  const auto pose = intake_.OdometryAt(At(50));
  ASSERT_TRUE(pose.has_value());
  EXPECT_NEAR(pose->translation_m.x(), 6.0, 1e-9);
  EXPECT_EQ(intake_.newest_motion(), At(100));
  EXPECT_EQ(intake_.NewestVelocity()->linear_mps.x(), 20.0);
}

TEST_F(TopicIntakeTest, WhatHasWaitedTooLongIsDroppedAndCounted) {
  ASSERT_TRUE(Take(CloudAt(At(5))).ok());
  const TopicIntake::Time first = now_;
  now_ += milliseconds(10);
  ASSERT_TRUE(Take(CloudAt(At(15))).ok());
  intake_.DropWaitingSince(first + milliseconds(1));
  EXPECT_EQ(intake_.dropped_count(), 1);
  now_ += milliseconds(50);
  ASSERT_EQ(Ready().size(), 1U);
}

TEST_F(TopicIntakeTest, AScanOfARadarThatIsNotInTheRigIsLeftOut) {
  rig_.radars.clear();
  ASSERT_TRUE(Take(CloudAt(At(5))).ok());
  ASSERT_TRUE(Take(VelocityAt(At(5), 10.0)).ok());
  EXPECT_TRUE(Ready().empty());
  EXPECT_EQ(intake_.dropped_count(), 1);
}

}  // namespace
}  // namespace dcloc::node
