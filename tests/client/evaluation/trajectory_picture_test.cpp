#include "client/evaluation/trajectory_picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>

namespace dcloc {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

Trajectory Way(const std::string& name, const Eigen::Vector3d& step_m) {
  Trajectory way{.name = name, .anchor = std::nullopt, .poses = {}};
  for (int i = 0; i < 10; ++i) {
    way.poses.push_back({Stamp(std::chrono::seconds(i)), {i * step_m, {1.0, 0.0, 0.0, 0.0}}});
  }
  return way;
}

TEST(TrajectoryPictureTest, ThePictureIsAsHighAsItsTracks) {
  const Picture flat = DrawTrajectories({Way("a.tum", {100.0, 0.0, 0.0})}, std::nullopt);
  const Picture high = DrawTrajectories({Way("a.tum", {50.0, 50.0, 0.0})}, std::nullopt);
  EXPECT_LT(flat.height_px, 450);
  EXPECT_GT(high.height_px, 1000);
  EXPECT_THAT(flat.commands, Not(HasSubstr("error")));
}

TEST(TrajectoryPictureTest, AReferenceAddsErrors) {
  const Trajectory way = Way("a.tum", {100.0, 0.0, 0.0});
  const Picture picture = DrawTrajectories({way}, Way("truth.tum", {100.0, 0.0, 0.1}));
  EXPECT_THAT(picture.commands, HasSubstr("position error [m]"));
  EXPECT_THAT(picture.commands, HasSubstr("9.0000 0.9000 0.0000\n"));
  EXPECT_GT(picture.height_px, DrawTrajectories({way}, std::nullopt).height_px + 400);
}

TEST(TrajectoryPictureTest, TheLegendHasNamesOrWhereTheyAreEqualPaths) {
  const Trajectory a = Way("x/it's.tum", {1.0, 0.0, 0.0});
  EXPECT_THAT(DrawTrajectories({a}, std::nullopt).commands, HasSubstr("title 'it''s.tum'"));
  const Trajectory b = Way("y/it's.tum", {1.0, 0.0, 0.0});
  EXPECT_THAT(DrawTrajectories({a, b}, std::nullopt).commands, HasSubstr("title 'y/it''s.tum'"));
}

}  // namespace
}  // namespace dcloc
