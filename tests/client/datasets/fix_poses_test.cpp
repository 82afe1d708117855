// Satellite fixes as poses: positions in a frame that drives share, and the course as heading.
#include "client/datasets/fix_poses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace dcloc {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kRadius_m = 50.0;

GeodeticAnchor Daejeon() { return {.origin = {.latitude_deg = 36.25, .longitude_deg = 127.25}}; }

/// Ten fixes a second along a circle at 5 m/s, after so many at its beginning.
BagContents OnACircle(int standing_count) {
  BagContents contents;
  for (int i = -standing_count; i < 100; ++i) {
    const double angle = 0.1 * 5.0 / kRadius_m * std::max(i, 0);
    const GeodeticPosition place =
        GeodeticFromMap(Daejeon(), {kRadius_m * std::cos(angle), kRadius_m * std::sin(angle), 7.0});
    rosbag::SatelliteFix fix;
    fix.header.stamp = Stamp(std::chrono::milliseconds(1'700'000'000'000 + std::int64_t{100} * i));
    fix.has_fix = true;
    fix.latitude_deg = place.latitude_deg;
    fix.longitude_deg = place.longitude_deg;
    fix.height_m = place.height_m;
    contents.fixes.push_back(fix);
  }
  return contents;
}

TEST(FixPosesTest, LookAlongTheWay) {
  BagContents contents = OnACircle(20);
  std::vector<std::string> notes;
  const absl::Status status = AddPosesOfFixes(contents, notes);
  ASSERT_TRUE(status.ok()) << status;
  EXPECT_THAT(notes, ElementsAre(HasSubstr("latitude 36.25, longitude 127.25")));
  ASSERT_EQ(contents.references.size(), 120U);
  for (std::size_t i = 30; i < 110; ++i) {
    const Pose3& pose = *contents.references[i].T_frame_child;
    const double angle = 0.1 * 5.0 / kRadius_m * (static_cast<double>(i) - 20.0);
    EXPECT_NEAR(pose.translation_m.x(), kRadius_m * std::cos(angle), 1e-6);
    EXPECT_NEAR(pose.translation_m.z(), 7.0, 1e-6);
    EXPECT_NEAR(WrapAngle(Yaw(pose.rotation) - angle - M_PI / 2.0), 0.0, 2e-3) << i;
  }
  // While it stands it looks where it will go.
  EXPECT_NEAR(Yaw(contents.references[0].T_frame_child->rotation), M_PI / 2.0, 0.02);
}

TEST(FixPosesTest, WithoutAWayThereIsNoHeading) {
  BagContents contents = OnACircle(0);
  contents.fixes.resize(2);
  std::vector<std::string> notes;
  const absl::Status status = AddPosesOfFixes(contents, notes);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("of 2 satellite fixes no two"));
}

TEST(FixPosesTest, FixesWithoutAPositionAreLeftOut) {
  BagContents contents = OnACircle(0);
  contents.fixes[50].has_fix = false;
  contents.fixes[50].latitude_deg = 0.0;
  std::vector<std::string> notes;
  ASSERT_TRUE(AddPosesOfFixes(contents, notes).ok());
  EXPECT_EQ(contents.references.size(), 99U);
}

}  // namespace
}  // namespace dcloc
