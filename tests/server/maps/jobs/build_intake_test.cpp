#include "server/maps/jobs/build_intake.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <vector>

#include "tests/core/map/temporary_folder.h"
#include "tests/server/fixtures/message_of.h"
#include "tests/server/fixtures/messages.h"

// What a survey is made of. What is taken at known poses is tested through the server.
namespace dcloc::server {
namespace {

using ::testing::HasSubstr;
using Message = v1::StartMapBuildRequest;

Message Header() {
  Message message;
  message.mutable_header()->set_map_name("town");
  message.mutable_header()->set_method(v1::MAP_BUILD_METHOD_SURVEY);
  return message;
}

Message DriveOf(const std::string& name) {
  Message message;
  message.mutable_drive()->set_name(name);
  *message.mutable_drive()->mutable_rig()->add_radars() = RadarMessage("front");
  return message;
}

Message ScanOf(std::int64_t number) {
  Message message;
  *message.mutable_scan()->mutable_scan() = ScanMessage(number);
  return message;
}

Message Spoilt(Message message, const std::function<void(Message&)>& spoil) {
  spoil(message);
  return message;
}

class BuildIntakeTest : public ::testing::Test {
 protected:
  absl::StatusOr<BuildInput> Take(const std::vector<Message>& messages) const {
    BuildIntake intake(folder_.path(), 1 << 20);
    for (const Message& message : messages) {
      if (absl::Status status = intake.Take(message); !status.ok()) return status;
    }
    return intake.Finish();
  }

  void ExpectRefused(const std::string& part, const std::vector<Message>& messages) const {
    const absl::Status status = Take(messages).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << part;
    EXPECT_THAT(MessageOf(status), HasSubstr(part));
    EXPECT_TRUE(std::filesystem::is_empty(folder_.path())) << "nothing is left";
  }

  TemporaryFolder folder_;
};

TEST_F(BuildIntakeTest, TakesDrivesThatBeginAtAnyTime) {
  const auto input = Take({Header(), DriveOf("a"), ScanOf(5), ScanOf(6), DriveOf("b"), ScanOf(1)});
  ASSERT_TRUE(input.ok()) << input.status();
  EXPECT_EQ(input->map_name, "town");
  EXPECT_EQ(input->method, v1::MAP_BUILD_METHOD_SURVEY);
  EXPECT_EQ(input->scan_count, 3);
  EXPECT_EQ(input->sha256.size(), 64U);
}

TEST_F(BuildIntakeTest, FaultsNameTheDriveTheScanAndTheField) {
  ExpectRefused("drive is missing", {Header()});
  ExpectRefused("scan 0: drive is missing", {Header(), ScanOf(1)});
  ExpectRefused("drive \"a\" has no scan", {Header(), DriveOf("a")});
  ExpectRefused("drive \"a\" has no scan", {Header(), DriveOf("a"), DriveOf("b"), ScanOf(1)});
  ExpectRefused("drive.name is \"a\", as of a drive before",
                {Header(), DriveOf("a"), ScanOf(1), DriveOf("a")});
  ExpectRefused("drive.name has 0 bytes", {Header(), DriveOf("")});
  ExpectRefused(
      "drive \"b\": drive.rig",
      {Header(), Spoilt(DriveOf("b"), [](Message& m) { m.mutable_drive()->clear_rig(); })});
  ExpectRefused("drive \"b\", scan 1: scan.stamp_ns is",
                {Header(), DriveOf("a"), ScanOf(9), DriveOf("b"), ScanOf(2), ScanOf(1)});
  ExpectRefused("drive \"a\", scan 0: scan.radar_id",
                {Header(), DriveOf("a"), Spoilt(ScanOf(1), [](Message& m) {
                   m.mutable_scan()->mutable_scan()->set_radar_id("rear");
                 })});
}

TEST_F(BuildIntakeTest, WhatASurveyFindsIsNotGiven) {
  ExpectRefused("t_map_vehicle is given", {Header(), DriveOf("a"), Spoilt(ScanOf(1), [](auto& m) {
                                             *m.mutable_scan()->mutable_t_map_vehicle() =
                                                 IdentityPose();
                                           })});
  ExpectRefused("begins_pass is given", {Header(), DriveOf("a"), Spoilt(ScanOf(1), [](auto& m) {
                                           m.mutable_scan()->set_begins_pass(true);
                                         })});
  ExpectRefused("header.rig is given", {Spoilt(Header(), [](auto& m) {
                  *m.mutable_header()->mutable_rig()->add_radars() = RadarMessage("front");
                })});
  ExpectRefused("header.anchor is given",
                {Spoilt(Header(), [](auto& m) { m.mutable_header()->mutable_anchor(); })});
  ExpectRefused("header.method is 77", {Spoilt(Header(), [](auto& m) {
                  m.mutable_header()->set_method(static_cast<v1::MapBuildMethod>(77));
                })});
}

TEST_F(BuildIntakeTest, DrivesAreOfSurveysAlone) {
  ExpectRefused("only header.method MAP_BUILD_METHOD_SURVEY takes drives",
                {Spoilt(Header(),
                        [](auto& m) {
                          m.mutable_header()->clear_method();
                          *m.mutable_header()->mutable_rig()->add_radars() = RadarMessage("front");
                        }),
                 DriveOf("a")});
}

}  // namespace
}  // namespace dcloc::server
