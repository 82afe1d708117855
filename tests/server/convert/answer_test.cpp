#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <string>

#include "absl/strings/ascii.h"
#include "core/geometry/covariance.h"
#include "server/convert/geometry.h"
#include "server/convert/page.h"
#include "tests/server/convert/convert_fault.h"

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

// ---- Answers

TEST(ConvertAnswerTest, CovarianceTurnsToFixedAxesAndBack) {
  // A vehicle that heads along the map's y axis, sure ahead and unsure to its left.
  v1::PoseWithCovariance message = InitialPoseMessage();
  const double half = std::numbers::pi / 4.0;
  message.mutable_pose()->mutable_rotation()->set_w(std::cos(half));
  message.mutable_pose()->mutable_rotation()->set_z(std::sin(half));
  message.set_covariance(0, 9.0);
  message.set_covariance(7, 1.0);
  v1::OpenSession open = OpenMessage();
  *open.mutable_initial_pose() = message;
  const auto pose = convert::InitialPoseFromProto(open, std::nullopt);
  ASSERT_TRUE(pose.ok()) << pose.status();
  EXPECT_NEAR((*pose)->covariance(0, 0), 1.0, 1e-12) << "ahead is the map's y";
  EXPECT_NEAR((*pose)->covariance(1, 1), 9.0, 1e-12) << "left is the map's -x";
  v1::PoseWithCovariance back;
  convert::ToProto((*pose)->T_map_vehicle, (*pose)->covariance, &back);
  ASSERT_EQ(back.covariance_size(), 36);
  for (int i = 0; i < 36; ++i) EXPECT_NEAR(back.covariance(i), message.covariance(i), 1e-12) << i;
}

TEST(ConvertAnswerTest, CovarianceIsRowMajorOnTheWire) {
  Matrix6d covariance = Matrix6d::Identity();
  covariance(0, 5) = covariance(5, 0) = 0.25;
  v1::PoseWithCovariance message;
  convert::ToProto(Pose3(), covariance, &message);
  EXPECT_EQ(message.covariance(5), 0.25);
  EXPECT_EQ(message.covariance(30), 0.25);
  EXPECT_EQ(message.covariance(1), 0.0);
}

TEST(ConvertAnswerTest, HeadingFollowsTheMapsAxes) {
  const GeodeticAnchor east{.origin = kAnchor.origin, .x_axis_east_rad = 0.0};
  v1::GeodeticPose message;
  convert::ToProto(east, Pose3(), &message);
  EXPECT_NEAR(message.heading_deg(), 90.0, 1e-6);
  Pose3 south;
  south.rotation = Eigen::AngleAxisd(-std::numbers::pi / 2.0, Eigen::Vector3d::UnitZ());
  convert::ToProto(east, south, &message);
  EXPECT_NEAR(message.heading_deg(), 180.0, 1e-6);
  const GeodeticAnchor north{.origin = kAnchor.origin, .x_axis_east_rad = std::numbers::pi / 2.0};
  convert::ToProto(north, Pose3(), &message);
  EXPECT_NEAR(std::remainder(message.heading_deg(), 360.0), 0.0, 1e-6);
  EXPECT_GE(message.heading_deg(), 0.0);
  EXPECT_LT(message.heading_deg(), 360.0);
}

TEST(ConvertAnswerTest, CarriesStateQualityAndObservedDegreesOfFreedom) {
  Localization localization;
  localization.stamp = Stamp(std::chrono::nanoseconds(42));
  localization.state = LocalizationState::kLost;
  localization.observed[0] = localization.observed[1] = localization.observed[5] = true;
  localization.quality.inlier_count = 17;
  localization.quality.is_accepted = true;
  localization.quality.beta = {.error_s = 0.03, .sigma_s = 0.007, .is_wrong = true};
  v1::LocalizationResult message;
  convert::ToProto(localization, &message);
  EXPECT_EQ(message.stamp_ns(), 42);
  EXPECT_EQ(message.state(), v1::LOCALIZATION_STATE_LOST);
  EXPECT_EQ(message.observed_dof_mask(), 0b100011);
  EXPECT_EQ(message.quality().inlier_count(), 17);
  EXPECT_TRUE(message.quality().edge_valid());
  EXPECT_EQ(message.quality().beta_error_s(), 0.03);
  EXPECT_EQ(message.quality().beta_error_sigma_s(), 0.007);
  EXPECT_TRUE(message.quality().beta_is_wrong());
}

TEST(ConvertAnswerTest, CarriesTheHealthOfEachSourceByItsName) {
  const Rig rig = FrontRig();
  const Health health{.wheel_speed = {.is_used = false, .fault = SourceFault::kScale},
                      .yaw_rate = {.is_used = true, .fault = SourceFault::kNone},
                      .radars = {{.is_used = false, .fault = SourceFault::kMount}}};
  v1::Health message;
  for (int i = 0; i < 3; ++i) message.add_radars()->set_radar_id("before");
  convert::ToProto(health, rig, &message);
  EXPECT_FALSE(message.wheel_speed().used());
  EXPECT_EQ(message.wheel_speed().fault(), v1::SOURCE_FAULT_SCALE);
  EXPECT_TRUE(message.yaw_rate().used());
  EXPECT_EQ(message.yaw_rate().fault(), v1::SOURCE_FAULT_NONE);
  ASSERT_EQ(message.radars_size(), 1);
  EXPECT_EQ(message.radars(0).radar_id(), "front");
  EXPECT_EQ(message.radars(0).fault(), v1::SOURCE_FAULT_MOUNT);
}

TEST(ConvertAnswerTest, EachFaultHasItsNameOnTheWire) {
  for (std::size_t i = 0; i < kSourceFaultNames.size(); ++i) {
    v1::Health message;
    convert::ToProto(Health{.wheel_speed = {.fault = static_cast<SourceFault>(i)}}, Rig(),
                     &message);
    const std::string name = absl::AsciiStrToUpper(kSourceFaultNames[i]);
    EXPECT_EQ(v1::SourceFault_Name(message.wheel_speed().fault()), "SOURCE_FAULT_" + name);
  }
}

TEST(ConvertAnswerTest, AJumpIsThereOnceOneHasBeen) {
  Localization localization;
  v1::LocalizationResult message;
  convert::ToProto(localization, &message);
  EXPECT_EQ(message.resets().count(), 0);
  EXPECT_FALSE(message.resets().has_last_jump());
  EXPECT_FALSE(message.has_protection_level_m());
  localization.resets.count = 2;
  localization.resets.T_before_after.translation_m.y() = 3.0;
  localization.protection_level_m = 0.5;
  convert::ToProto(localization, &message);
  EXPECT_EQ(message.resets().count(), 2);
  EXPECT_EQ(message.resets().last_jump().translation_m().y(), 3.0);
  EXPECT_EQ(message.protection_level_m(), 0.5);
}

TEST(ConvertAnswerTest, NothingOfAnEarlierAnswerShowsThrough) {
  LocalizedScan scan{
      .map_version = 3, .rig = std::make_shared<const Rig>(FrontRig()), .anchor = kAnchor};
  scan.localization.health.radars.resize(scan.rig->radars.size());
  scan.localization.protection_level_m = 0.5;
  scan.localization.resets.count = 1;
  scan.timings.queue = std::chrono::nanoseconds(11);
  scan.timings.stamp_age = std::chrono::nanoseconds(-12);
  ScanAnswer answer{.sequence_number = 7, .result = scan, .dropped_scan_count = 2};
  v1::LocalizeResponse message;
  message.mutable_opened()->set_session_id("before");
  convert::ToProto(answer, &message);
  EXPECT_EQ(message.result().sequence_number(), 7);
  EXPECT_EQ(message.result().map_version(), 3);
  EXPECT_TRUE(message.result().has_geodetic_pose());
  EXPECT_EQ(message.result().timings().queue_duration_ns(), 11);
  EXPECT_EQ(message.result().timings().stamp_age_ns(), -12);
  EXPECT_EQ(message.dropped_scan_count(), 2);

  for (const bool anchored : {false, true}) {
    answer.from_memory = !anchored;
    answer.result->anchor.reset();
    answer.result->rig.reset();
    answer.result->localization.protection_level_m.reset();
    answer.result->localization.resets = {};
    if (anchored) answer.result->anchor = kAnchor;
    convert::ToProto(answer, &message);
    v1::LocalizeResponse fresh;
    convert::ToProto(answer, &fresh);
    EXPECT_EQ(message.SerializeAsString(), fresh.SerializeAsString());
  }
  answer.result = absl::OutOfRangeError("late");
  convert::ToProto(answer, &message);
  EXPECT_EQ(message.rejected().sequence_number(), 7);
  EXPECT_EQ(message.rejected().code(), static_cast<int>(absl::StatusCode::kOutOfRange));
  EXPECT_EQ(message.rejected().message(), "late");
}

// ---- Pages

TEST(ConvertPageTest, SizesAndTokens) {
  EXPECT_EQ(*convert::PageSizeFromProto(0), 100);
  EXPECT_EQ(*convert::PageSizeFromProto(7), 7);
  EXPECT_EQ(convert::PageSizeFromProto(-1).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(convert::PageSizeFromProto(1001).status().message()),
              HasSubstr("page_size is 1001"));
  EXPECT_EQ(*convert::NumberFromPageToken("", 9), 9);
  EXPECT_EQ(*convert::NumberFromPageToken("12", 9), 12);
  EXPECT_FALSE(convert::NumberFromPageToken("x", 9).ok());
  EXPECT_FALSE(convert::NumberFromPageToken("-3", 9).ok());
  EXPECT_FALSE(convert::CheckPageToken("a b").ok());
}

}  // namespace
}  // namespace dcloc::server
