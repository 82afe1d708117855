#include "core/passes/pass_track.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/passes/street_fixture.h"

namespace dcloc {
namespace {

TEST(PassTrackTest, BeginsWhereThePassIs) {
  const PassTrack track(TestStreet().Pass(1, "a"), {});
  ASSERT_EQ(track.scans().size(), track.T_map_vehicles().size());
  for (std::size_t i = 0; i < track.scans().size(); ++i) {
    EXPECT_NEAR(track.T_map_vehicles()[i].translation_m.x(), static_cast<double>(i), 1e-6);
  }
}

TEST(PassTrackTest, APullMovesThePoseItIsOf) {
  PassTrack track(TestStreet().Pass(1, "a"), {});
  std::vector<PosePull> pulls(track.scans().size());
  const Eigen::Vector3d step(0.2, -0.1, 0.0);
  for (PosePull& pull : pulls) {
    pull.information = 1e4 * Eigen::Matrix3d::Identity();
    pull.pull = pull.information * step;
  }
  track.Move(pulls);
  EXPECT_NEAR(track.T_map_vehicles()[100].translation_m.x(), 100.2, 0.01);
  EXPECT_NEAR(track.T_map_vehicles()[100].translation_m.y(), -0.1, 0.01);
}

}  // namespace
}  // namespace dcloc
