#include "server/convert/initial_pose.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/server/convert/convert_fault.h"

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

/// At (3, 4) in the map, turned by a right angle to the left; sigmas of 2 m along x and 1 m along
/// y.
v1::PoseWithCovariance TurnedPose() {
  v1::PoseWithCovariance message = FixMessage(1).map_pose();
  v1::Pose& pose = *message.mutable_pose();
  pose.mutable_translation_m()->set_x(3.0);
  pose.mutable_translation_m()->set_y(4.0);
  pose.mutable_rotation()->set_w(std::sqrt(0.5));
  pose.mutable_rotation()->set_z(std::sqrt(0.5));
  message.set_covariance(0, 4.0);
  message.set_covariance(7, 1.0);
  return message;
}

TEST(ConvertInitialPoseTest, TheCovarianceTurnsFromTheMapsAxesToTheVehicles) {
  const auto pose = convert::FromProto(TurnedPose(), "open.initial_pose");
  ASSERT_TRUE(pose.ok()) << pose.status();
  EXPECT_EQ(pose->T_map_vehicle.translation_m.x(), 3.0);
  EXPECT_NEAR(pose->covariance(0, 0), 1.0, 1e-9);  // the vehicle looks along the map's y
  EXPECT_NEAR(pose->covariance(1, 1), 4.0, 1e-9);
}

TEST(ConvertInitialPoseTest, AFixWithoutHeadingLeavesTheHeadingOpen) {
  v1::GnssFix message = GnssFixMessage();
  const auto open = convert::FromProto(message, kAnchor, "open.gnss_fix");
  ASSERT_TRUE(open.ok()) << open.status();
  EXPECT_GT(std::sqrt(open->covariance(5, 5)), 1.0);
  message.set_heading_deg(90.0);
  message.set_heading_sigma_deg(2.0);
  const auto known = convert::FromProto(message, kAnchor, "open.gnss_fix");
  ASSERT_TRUE(known.ok()) << known.status();
  EXPECT_LT(std::sqrt(known->covariance(5, 5)), 0.1);
}

TEST(ConvertInitialPoseTest, FaultsAreNamedUnderTheField) {
  v1::GnssFix message = GnssFixMessage();
  EXPECT_EQ(convert::FromProto(message, std::nullopt, "fix").status().code(),
            absl::StatusCode::kFailedPrecondition);
  message.set_horizontal_sigma_m(kNan);
  EXPECT_THAT(std::string(convert::FromProto(message, kAnchor, "fix").status().message()),
              HasSubstr("fix.horizontal_sigma_m"));
  message = GnssFixMessage();
  message.set_heading_deg(361.0);
  message.set_heading_sigma_deg(1.0);
  EXPECT_THAT(std::string(convert::FromProto(message, kAnchor, "fix").status().message()),
              HasSubstr("fix.heading_deg"));
}

}  // namespace
}  // namespace dcloc::server
