#include "client/datasets/fix_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "tests/core/map/temporary_folder.h"

namespace dcloc {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class FixFileTest : public ::testing::Test {
 protected:
  absl::StatusOr<std::vector<StampedFix>> Read(const std::string& text) const {
    std::ofstream(file_) << text;
    return ReadFixes(file_);
  }

  std::string ErrorOf(const std::string& text) const {
    return std::string(Read(text).status().message());
  }

  const TemporaryFolder folder_;
  const std::filesystem::path file_ = folder_.path() / "fixes.csv";
};

constexpr char kGeodetic[] =
    "stamp_ns,latitude_deg,longitude_deg,height_m,horizontal_sigma_m,vertical_sigma_m,"
    "heading_deg,heading_sigma_deg\n";
constexpr char kMap[] = "stamp_ns,x_m,y_m,z_m,horizontal_sigma_m,vertical_sigma_m\n";

TEST_F(FixFileTest, TheHeaderSaysWhichKindItIs) {
  const auto earth = Read(std::string(kGeodetic) +
                          "20,52.5,8.25,100,1.5,3,90,2\r\n"
                          "\n"
                          "10,52.5,8.25,100,1.5,3,,\n");
  ASSERT_TRUE(earth.ok()) << earth.status();
  ASSERT_EQ(earth->size(), 2U);
  EXPECT_EQ((*earth)[0].stamp.time_since_epoch().count(), 10) << "by stamp";
  EXPECT_FALSE(std::get<GnssFix>((*earth)[0].position).heading_deg.has_value());
  const GnssFix& fix = std::get<GnssFix>((*earth)[1].position);
  EXPECT_EQ(fix.position.latitude_deg, 52.5);
  EXPECT_EQ(fix.position.longitude_deg, 8.25);
  EXPECT_EQ(fix.vertical_sigma_m, 3.0);
  EXPECT_EQ(fix.heading_deg, 90.0);
  EXPECT_EQ(fix.heading_sigma_deg, 2.0);
  const auto map = Read(std::string(kMap) + "10,1,-2,0.5,1.5,3\n");
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_EQ(std::get<MapFix>((*map)[0].position).p_map, Eigen::Vector3d(1.0, -2.0, 0.5));
}

TEST_F(FixFileTest, ColumnsMayStandInAnyOrder) {
  const auto fixes =
      Read("z_m,y_m,x_m,vertical_sigma_m,horizontal_sigma_m,stamp_ns\n3,2,1,5,4,9\n");
  ASSERT_TRUE(fixes.ok()) << fixes.status();
  const MapFix& fix = std::get<MapFix>((*fixes)[0].position);
  EXPECT_EQ(fix.p_map, Eigen::Vector3d(1.0, 2.0, 3.0));
  EXPECT_EQ(fix.horizontal_sigma_m, 4.0);
}

TEST_F(FixFileTest, ErrorsNameFileLineColumnValueAndBound) {
  const std::string map = kMap;
  EXPECT_THAT(ErrorOf(map + "10,1,2,3,1,1\n11,1,2,3,-1,1\n"),
              AllOf(HasSubstr(file_.string()), HasSubstr("line 3"), HasSubstr("horizontal_sigma_m"),
                    HasSubstr("is -1"), HasSubstr("0.001")));
  EXPECT_THAT(ErrorOf(map + "10,one,2,3,1,1\n"),
              AllOf(HasSubstr("line 2"), HasSubstr("x_m is \"one\""), HasSubstr("1e+08")));
  EXPECT_THAT(ErrorOf(map + "10,nan,2,3,1,1\n"), HasSubstr("x_m is nan"));
  EXPECT_THAT(ErrorOf(map + "0,1,2,3,1,1\n"),
              AllOf(HasSubstr("stamp_ns is \"0\""), HasSubstr("[1, 4102444800000000000]")));
  EXPECT_THAT(ErrorOf(map + "1e9,1,2,3,1,1\n"), HasSubstr("stamp_ns is \"1e9\""));
  EXPECT_THAT(ErrorOf(map + "10,1,2,3,1\n"),
              AllOf(HasSubstr("5 columns"), HasSubstr("6 as the header")));
  EXPECT_THAT(ErrorOf(std::string(kGeodetic) + "10,91,8,0,1,1,,\n"),
              AllOf(HasSubstr("latitude_deg is 91"), HasSubstr("[-90, 90]")));
  EXPECT_THAT(ErrorOf(std::string(kGeodetic) + "10,52,8,0,1,1,90,\n"),
              HasSubstr("heading_sigma_deg is \"\""));
}

TEST_F(FixFileTest, AHeaderThatIsNoneIsNamed) {
  EXPECT_THAT(ErrorOf(""), HasSubstr("is empty"));
  EXPECT_THAT(ErrorOf("time,x_m\n"), HasSubstr("no column stamp_ns"));
  EXPECT_THAT(ErrorOf("stamp_ns,x_m,y_m\n"), HasSubstr("no column z_m"));
  EXPECT_THAT(ErrorOf("stamp_ns,x_m,y_m,z_m,horizontal_sigma_m,vertical_sigma_m,yaw_deg\n"),
              HasSubstr("both or none of yaw_deg and yaw_sigma_deg"));
  EXPECT_THAT(ErrorOf("stamp_ns,x_m,y_m,z_m,horizontal_sigma_m,vertical_sigma_m,speed\n"),
              AllOf(HasSubstr("line 1"), HasSubstr("7 columns"), HasSubstr("6 of them are known")));
  EXPECT_EQ(ReadFixes(folder_.path() / "none").status().code(), absl::StatusCode::kNotFound);
}

TEST_F(FixFileTest, WhatIsWrittenIsReadAgain) {
  const std::vector<StampedFix> written = {
      {Stamp(std::chrono::nanoseconds(5)), MapFix{.p_map = {1.25, -2.5, 0.125},
                                                  .horizontal_sigma_m = 1.5,
                                                  .vertical_sigma_m = 3.0,
                                                  .yaw_deg = -90.0,
                                                  .yaw_sigma_deg = 2.0}},
      {Stamp(std::chrono::nanoseconds(6)),
       MapFix{.p_map = {0.0, 0.0, 0.0}, .horizontal_sigma_m = 1.0, .vertical_sigma_m = 1.0}}};
  ASSERT_TRUE(WriteFixes(file_, written).ok());
  const auto read = ReadFixes(file_);
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->size(), 2U);
  const MapFix& fix = std::get<MapFix>((*read)[0].position);
  EXPECT_EQ(fix.p_map, Eigen::Vector3d(1.25, -2.5, 0.125));
  EXPECT_EQ(fix.yaw_deg, -90.0);
  EXPECT_FALSE(std::get<MapFix>((*read)[1].position).yaw_deg.has_value());
  EXPECT_FALSE(WriteFixes(folder_.path() / "no/folder", written).ok());
}

TEST_F(FixFileTest, AFixWithoutAYawKnowsNoneOfIt) {
  MapFix fix{.p_map = {1.0, 2.0, 3.0}, .horizontal_sigma_m = 2.0, .vertical_sigma_m = 4.0};
  const InitialPose anyhow = PoseOf(fix);
  EXPECT_NEAR(anyhow.covariance(5, 5), 3.29, 0.01);
  EXPECT_NEAR(anyhow.covariance(0, 0), 4.0, 1e-12);
  EXPECT_NEAR(anyhow.covariance(2, 2), 16.0, 1e-12);
  fix.yaw_deg = 90.0;
  fix.yaw_sigma_deg = 1.0;
  const InitialPose turned = PoseOf(fix);
  EXPECT_NEAR((turned.T_map_vehicle.rotation * Eigen::Vector3d::UnitX()).y(), 1.0, 1e-12);
  EXPECT_NEAR(turned.covariance(5, 5), 3.05e-4, 1e-5);
}

}  // namespace
}  // namespace dcloc
