#include "server/maps/jobs/map_build.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/server/fixtures/message_of.h"
#include "tests/server/fixtures/messages.h"

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

v1::MapBuildHeader Header() {
  v1::MapBuildHeader header;
  header.set_map_name("town");
  header.set_drive_name("monday");
  header.set_activate(true);
  *header.mutable_rig()->add_radars() = RadarMessage("front");
  return header;
}

TEST(MapBuildTest, WhatAClientAsksForIsWhatIsBuilt) {
  v1::MapBuildHeader header = Header();
  header.mutable_anchor()->mutable_origin()->set_latitude_deg(52.0);
  const auto request = FromProto(header);
  ASSERT_TRUE(request.ok()) << request.status();
  EXPECT_EQ(request->options.name, "monday");
  EXPECT_TRUE(request->activate);
  ASSERT_EQ(request->rig.radars.size(), 1U);
  EXPECT_EQ(request->options.anchor->origin.latitude_deg, 52.0);
}

TEST(MapBuildTest, FaultsAreNamedUnderTheHeader) {
  const auto message = [](const auto& spoil) {
    v1::MapBuildHeader header = Header();
    spoil(header);
    return MessageOf(FromProto(header).status());
  };
  EXPECT_THAT(message([](auto& header) { header.set_map_name("a/b"); }),
              HasSubstr("header.map_name"));
  EXPECT_THAT(message([](auto& header) { header.set_description(std::string(1'001, 'x')); }),
              HasSubstr("header.description has 1001 bytes"));
  EXPECT_THAT(message([](auto& header) { header.clear_rig(); }), HasSubstr("header.rig"));
  EXPECT_THAT(message([](auto& header) {
                header.mutable_anchor()->mutable_origin()->set_latitude_deg(91.0);
              }),
              HasSubstr("header.anchor.origin"));
}

TEST(MapBuildTest, ABuildIsToldAsItsBuilderReportsIt) {
  v1::MapBuild report;
  report.set_done_scan_count(4);
  report.set_stage("placing scans");
  report.set_stage_share(0.5);
  BuildRow row{.build_id = "x", .map_name = "town", .report = report.SerializeAsString()};
  row.attempt_count = 2;
  v1::MapBuild message;
  ToProto(row, &message);
  EXPECT_EQ(message.build_id(), "x");
  EXPECT_EQ(message.map_name(), "town");
  EXPECT_EQ(message.state(), v1::MAP_BUILD_STATE_RUNNING);
  EXPECT_EQ(message.done_scan_count(), 4);
  EXPECT_EQ(message.stage(), "placing scans");
  EXPECT_EQ(message.stage_share(), 0.5);
  EXPECT_EQ(message.attempt_count(), 2);
}

TEST(MapBuildTest, AFailedBuildSaysWhyAndIsInNoStage) {
  v1::MapBuild report;
  report.set_stage("placing scans");
  report.set_error_code(static_cast<int>(absl::StatusCode::kResourceExhausted));
  report.set_error_message("the disk is full");
  const BuildRow row{.state = BuildState::kFailed, .report = report.SerializeAsString()};
  v1::MapBuild message;
  ToProto(row, &message);
  EXPECT_EQ(message.state(), v1::MAP_BUILD_STATE_FAILED);
  EXPECT_EQ(message.error_code(), static_cast<int>(absl::StatusCode::kResourceExhausted));
  EXPECT_EQ(message.error_message(), "the disk is full");
  EXPECT_FALSE(message.has_version());
  EXPECT_EQ(message.stage(), "");
}

}  // namespace
}  // namespace dcloc::server
