#include "client/datasets/bag_mapping.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/client/datasets/temp_folder.h"

namespace dcloc {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

BagMapping Mapping() {
  RadarMapping front;
  front.id = "front";
  front.topic = "/radar/front";
  front.range = "range";
  front.azimuth = "azimuth";
  front.range_rate = "doppler";
  front.azimuth_is_clockwise = true;
  front.T_vehicle_radar = Pose3{{3.5, 0.0, 0.5}, Eigen::Quaterniond::Identity()};
  RadarMapping rear;
  rear.id = "rear";
  rear.topic = "/radar/rear";
  rear.x = "x";
  rear.y = "y";
  rear.range_rate = "vr";
  BagMapping mapping;
  mapping.radars = {front, rear};
  mapping.motion_topic = "/odom";
  mapping.map_frame = "utm";
  return mapping;
}

class BagMappingTest : public ::testing::Test {
 protected:
  absl::StatusOr<BagMapping> Read(const std::string& text) const {
    return ReadBagMapping(folder_.Write("dcloc_bag.json", text));
  }
  std::string ErrorOf(const std::string& text) const {
    return std::string(Read(text).status().message());
  }

  const TempFolder folder_;
};

TEST_F(BagMappingTest, WhatIsWrittenIsReadAgain) {
  const auto mapping = Read(BagMappingJson(Mapping()).dump());
  ASSERT_TRUE(mapping.ok()) << mapping.status();
  EXPECT_EQ(BagMappingJson(*mapping), BagMappingJson(Mapping()));
  EXPECT_EQ(mapping->radars[0].T_vehicle_radar->translation_m.x(), 3.5);
  EXPECT_TRUE(mapping->radars[0].azimuth_is_clockwise);
  EXPECT_FALSE(mapping->radars[1].HasElevation());
  EXPECT_EQ(mapping->vehicle_frame, "base_link");
}

TEST_F(BagMappingTest, AnUnknownKeyIsNotPassedOver) {
  EXPECT_THAT(ErrorOf(R"({"radars": [], "odom_topic": "/odom"})"),
              AllOf(HasSubstr("dcloc_bag.json"), HasSubstr("odom_topic")));
  EXPECT_THAT(ErrorOf(R"({"radars": [{"id": "front", "clockwise": true}]})"),
              AllOf(HasSubstr("radar front"), HasSubstr("clockwise")));
}

TEST_F(BagMappingTest, AValueOfAnotherTypeIsNamed) {
  EXPECT_THAT(ErrorOf(R"({"radars": [{"id": "front", "angles_in_degrees": "yes"}]})"),
              HasSubstr("angles_in_degrees"));
  EXPECT_THAT(ErrorOf(R"({"radars": [{"id": "f", "T_vehicle_radar": [1, 2, 3]}]})"),
              HasSubstr("seven numbers"));
  EXPECT_THAT(ErrorOf(R"({"radars": [{"id": "f", "T_vehicle_radar": [1, 2, 3, 0, 0, 0, 0]}]})"),
              HasSubstr("quaternion"));
  EXPECT_THAT(ErrorOf("{"), HasSubstr("dcloc_bag.json"));
}

TEST_F(BagMappingTest, EachRadarSaysWhereItsTargetsAre) {
  const auto error_of = [](const auto& spoil) {
    BagMapping mapping = Mapping();
    spoil(mapping);
    return std::string(Validate(mapping).message());
  };
  EXPECT_TRUE(Validate(Mapping()).ok());
  EXPECT_THAT(error_of([](auto& m) { m.radars[0].azimuth.clear(); }), HasSubstr("radar front"));
  EXPECT_THAT(error_of([](auto& m) { m.radars[1].range = "r"; }), HasSubstr("range and azimuth"));
  EXPECT_THAT(error_of([](auto& m) { m.radars[1].range_rate.clear(); }), HasSubstr("range_rate"));
  EXPECT_THAT(error_of([](auto& m) { m.radars[1].topic = m.radars[0].topic; }),
              HasSubstr("radar rear"));
  EXPECT_THAT(error_of([](auto& m) { m.vehicle_frame.clear(); }), HasSubstr("vehicle_frame"));
}

}  // namespace
}  // namespace dcloc
