// What message_writer writes, message_reader reads.
#include "client/rosbag/message_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>

#include "client/rosbag/bag_bytes.h"
#include "client/rosbag/message_types.h"
#include "client/rosbag/message_writer.h"

namespace dcloc::rosbag {
namespace {

using ::testing::HasSubstr;

const Header kHeader{Stamp(std::chrono::nanoseconds(1'700'000'000'000'000'001)), "front"};

/// Two points of a range (float32) and a count (int16).
PointCloud Cloud() {
  PointCloud cloud{.header = kHeader,
                   .fields = {{"range", 0, 7, 1}, {"count", 4, 3, 1}},
                   .point_count = 2,
                   .point_bytes = 6,
                   .data = {}};
  for (const auto& [range, count] : {std::pair(1.5F, 3), std::pair(-2.25F, -4)}) {
    AppendNumber(cloud.data, range);
    AppendNumber(cloud.data, static_cast<std::int16_t>(count));
  }
  return cloud;
}

TEST(MessageReaderTest, APointCloudComesBackWithItsFields) {
  const auto cloud = ParsePointCloud(FormatPointCloud(Cloud()));
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  EXPECT_EQ(cloud->header.stamp, kHeader.stamp);
  EXPECT_EQ(cloud->header.frame_id, "front");
  ASSERT_EQ(cloud->point_count, 2U);
  ASSERT_NE(cloud->Find("count"), nullptr);
  EXPECT_EQ(cloud->Value(*cloud->Find("range"), 1), -2.25);
  EXPECT_EQ(cloud->Value(*cloud->Find("count"), 1), -4.0);
  EXPECT_EQ(cloud->Find("snr"), nullptr);
}

TEST(MessageReaderTest, AFieldBeyondItsPointAndACutMessageAreDamage) {
  PointCloud cloud = Cloud();
  cloud.fields[1].offset = 5;  // two bytes of six from the fifth on
  EXPECT_EQ(ParsePointCloud(FormatPointCloud(cloud)).status().code(), absl::StatusCode::kDataLoss);
  const std::string whole = FormatPointCloud(Cloud());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_EQ(ParsePointCloud(absl::string_view(whole).substr(0, size)).status().code(),
              absl::StatusCode::kDataLoss)
        << size;
  }
}

TEST(MessageReaderTest, AVelocityComesBackAndUnknownIsWrittenAsZero) {
  EgoVelocity velocity;
  velocity.linear_mps = {12.5, -0.1, 0.0};
  velocity.angular_radps = {0.0, 0.0, 0.3};
  velocity.covariance = 0.25 * Matrix6d::Identity();
  const auto motion =
      ParseMotion(kTwistWithCovarianceStamped.name, FormatVelocity(kHeader, velocity));
  ASSERT_TRUE(motion.ok()) << motion.status();
  ASSERT_TRUE(motion->velocity.has_value());
  EXPECT_EQ(motion->velocity->linear_mps, velocity.linear_mps);
  EXPECT_EQ(motion->velocity->angular_radps, velocity.angular_radps);
  EXPECT_EQ(motion->velocity->covariance, velocity.covariance);
  EXPECT_FALSE(motion->T_frame_child.has_value());
}

TEST(MessageReaderTest, TransformsComeBackToTheBitAndNanIsDamage) {
  const Pose3 pose{{1.0, 2.0, 3.0}, Eigen::Quaterniond(0.5, 0.5, 0.5, 0.5)};
  Transform transform{kHeader.stamp, "map", "base_link", pose};
  const auto transforms = ParseTransforms(FormatTransforms({transform}));
  ASSERT_TRUE(transforms.ok()) << transforms.status();
  ASSERT_EQ(transforms->size(), 1U);
  EXPECT_EQ(transforms->front().parent, "map");
  EXPECT_EQ(transforms->front().T_parent_child.rotation.coeffs(), pose.rotation.coeffs());
  transform.T_parent_child.translation_m.y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(ParseTransforms(FormatTransforms({transform})).status().code(),
            absl::StatusCode::kDataLoss);
}

TEST(MessageReaderTest, PosesAndOdometryComeBackWithTheirCovariance) {
  Motion motion{.header = kHeader, .child_frame = "base_link"};
  motion.T_frame_child = Pose3{{1.0, 2.0, 3.0}, Eigen::Quaterniond(0.5, 0.5, 0.5, 0.5)};
  motion.pose_covariance = 0.25 * Matrix6d::Identity();
  (*motion.pose_covariance)(0, 1) = 0.125;
  motion.velocity.emplace();
  motion.velocity->linear_mps.x() = 12.5;
  const auto pose = ParseMotion(kPoseWithCovarianceStamped.name, FormatPose(motion));
  ASSERT_TRUE(pose.ok()) << pose.status();
  EXPECT_EQ(pose->T_frame_child->translation_m, motion.T_frame_child->translation_m);
  EXPECT_EQ(pose->T_frame_child->rotation.coeffs(), motion.T_frame_child->rotation.coeffs());
  EXPECT_EQ(pose->pose_covariance, motion.pose_covariance);
  EXPECT_FALSE(pose->velocity.has_value());
  const auto odometry = ParseMotion(kOdometry.name, FormatOdometry(motion));
  ASSERT_TRUE(odometry.ok()) << odometry.status();
  EXPECT_EQ(odometry->child_frame, "base_link");
  EXPECT_EQ(odometry->pose_covariance, motion.pose_covariance);
  EXPECT_EQ(odometry->velocity->linear_mps.x(), 12.5);
  EXPECT_FALSE(odometry->velocity->covariance.has_value());
}

TEST(MessageReaderTest, DiagnosticsAreWrittenAsTheyAreLaidOut) {
  const std::string bytes = FormatDiagnostics(
      kHeader.stamp, {{.level = Diagnostic::Level::kError, .name = "n", .values = {{"k", "v"}}}});
  ByteReader reader(bytes);
  reader.Take<std::uint32_t>();
  EXPECT_EQ(reader.TakeTime(), kHeader.stamp);
  EXPECT_EQ(reader.TakeText(), "");
  EXPECT_EQ(reader.Take<std::uint32_t>(), 1U);
  EXPECT_EQ(reader.Take<std::int8_t>(), 2);
  EXPECT_EQ(reader.TakeText(), "n");
  EXPECT_EQ(reader.TakeText(), "");
  EXPECT_EQ(reader.TakeText(), "");
  EXPECT_EQ(reader.Take<std::uint32_t>(), 1U);
  EXPECT_EQ(reader.TakeText(), "k");
  EXPECT_EQ(reader.TakeText(), "v");
  EXPECT_TRUE(reader.ok() && reader.rest().empty());
}

TEST(MessageReaderTest, WhatIsWrittenHasADefinition) {
  for (const MessageType& type : {kPointCloud2, kTwistWithCovarianceStamped, kTf2, kOdometry,
                                  kPoseWithCovarianceStamped, kDiagnosticArray}) {
    EXPECT_FALSE(DefinitionOf(type).empty()) << type.name;
  }
}

TEST(MessageReaderTest, AnotherLayoutOfAKnownTypeIsRefusedByName) {
  const MessageType& known = kPointCloud2;
  EXPECT_TRUE(CheckType({"/radar", known.name, known.md5sum}).ok());
  const absl::Status changed = CheckType({"/radar", known.name, std::string(32, '0')});
  EXPECT_EQ(changed.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(changed.message()), HasSubstr("/radar"));
  EXPECT_FALSE(CheckType({"/radar", "custom/Radar", known.md5sum}).ok());
  EXPECT_EQ(FindType("custom/Radar"), nullptr);
  for (const MessageType& type : KnownTypes()) EXPECT_EQ(FindType(type.name)->md5sum, type.md5sum);
}

}  // namespace
}  // namespace dcloc::rosbag
