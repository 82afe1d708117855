#include "client/datasets/files/radar_pcd.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "tests/client/datasets/tiny_nuscenes.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

std::string Replace(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(ReadRadarPcd, ReadsTheOfficialFields) {
  const TempFolder folder;
  const auto path = folder.Write(
      "sweep.pcd", PcdBytes({{1.0F, 2.0F, 3.0F, 4.0F, 5.0F, 6.5F, 2, 4, -1}, {7.0F, 8.0F}}));
  const auto targets = ReadRadarPcd(path);
  ASSERT_TRUE(targets.ok()) << targets.status();
  ASSERT_EQ(targets->size(), 2U);
  const RadarPcdTarget& target = targets->front();
  EXPECT_EQ(target.x_m, 1.0F);
  EXPECT_EQ(target.y_m, 2.0F);
  EXPECT_EQ(target.z_m, 3.0F);
  EXPECT_EQ(target.vx_mps, 4.0F);
  EXPECT_EQ(target.vy_mps, 5.0F);
  EXPECT_EQ(target.rcs_dbsm, 6.5F);
  EXPECT_EQ(target.dyn_prop, 2);
  EXPECT_EQ(target.ambig_state, 4);
  EXPECT_EQ(target.invalid_state, -1);
  EXPECT_EQ(targets->back().x_m, 7.0F);
}

TEST(ReadRadarPcd, LeavesOutRowsWithNan) {
  const TempFolder folder;
  const auto path = folder.Write(
      "sweep.pcd",
      PcdBytes({{kNan, kNan, kNan, kNan, kNan}, {1.0F, 2.0F}, {1.0F, 2.0F, 0.0F, kNan}}));
  const auto targets = ReadRadarPcd(path);
  ASSERT_TRUE(targets.ok()) << targets.status();
  EXPECT_EQ(targets->size(), 1U);
}

TEST(ReadRadarPcd, AcceptsAFileWithoutPoints) {
  const TempFolder folder;
  const auto targets = ReadRadarPcd(folder.Write("sweep.pcd", PcdBytes({})));
  ASSERT_TRUE(targets.ok()) << targets.status();
  EXPECT_TRUE(targets->empty());
}

TEST(ReadRadarPcd, NamesFileAndFault) {
  const TempFolder folder;
  const std::string good = PcdBytes({{1.0F, 2.0F}, {3.0F, 4.0F}});
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "no DATA line"},
      {"garbage", "no DATA line"},
      {std::string(300, '\0'), "no DATA line"},
      {good.substr(0, good.size() - 1), "is truncated: 2 points of 43 bytes need 86 bytes"},
      {Replace(good, "POINTS 2", "POINTS 3"), "WIDTH 2, HEIGHT 1 and POINTS 3"},
      {Replace(Replace(good, "POINTS 2", "POINTS 900000"), "WIDTH 2", "WIDTH 900000"), "truncated"},
      {Replace(good, "WIDTH 2", "WIDTH 99999999999999999999"), "WIDTH line must hold one number"},
      {Replace(good, "WIDTH 2", "WIDTH -2"), "WIDTH line must hold one number"},
      {Replace(good, "WIDTH 2", "WIDTH"), "WIDTH line must hold one number"},
      {Replace(good, "HEIGHT 1\n", ""), "HEIGHT line must hold one number"},
      {Replace(good, "VERSION 0.7", "POINTS 2"), "two POINTS lines"},
      {Replace(good, "DATA binary", "DATA ascii"), "DATA line must say binary"},
      {Replace(good, "DATA binary", "DATA"), "DATA line must say binary"},
      {Replace(good, kPcdFields, ""), "no FIELDS line"},
      {Replace(good, "FIELDS x y", "FIELDS y"), "entries for 17 fields"},
      {Replace(good, " vx vy ", " wx vy "), "has no field vx"},
      {Replace(good, "SIZE 4 4", "SIZE 8 4"), "truncated"},
      {Replace(good, "SIZE 4 4", "SIZE 0 4"), "gives field x size 0"},
      {Replace(good, "SIZE 4 4", "SIZE x 4"), "gives field x size x"},
      {Replace(good, "COUNT 1", "COUNT 4000"), "larger than 4096 bytes"},
      {Replace(good, "TYPE F", "TYPE U"), "field x must have type F and size 4"},
  };
  for (const auto& [bytes, fault] : cases) {
    const auto path = folder.Write("broken.pcd", bytes);
    const auto targets = ReadRadarPcd(path);
    ASSERT_FALSE(targets.ok()) << fault;
    EXPECT_EQ(targets.status().code(), absl::StatusCode::kDataLoss);
    EXPECT_THAT(std::string(targets.status().message()),
                AllOf(HasSubstr(path.string()), HasSubstr(fault)));
  }
}

TEST(ReadRadarPcd, SaysThatAFileIsNotThere) {
  const TempFolder folder;
  EXPECT_EQ(ReadRadarPcd(folder.path() / "none.pcd").status().code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace dcloc
