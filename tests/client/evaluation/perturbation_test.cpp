#include "client/evaluation/perturbation.h"

#include <gtest/gtest.h>

#include <numbers>
#include <set>

namespace dcloc {
namespace {

Pose3 Truth() {
  Pose3 truth = Embed(Pose2{{100.0, -50.0}, 2.0});
  truth.translation_m.z() = 7.0;
  return truth;
}

TEST(Perturb, MovesAndTurnsByExactlyWhatIsAsked) {
  const Perturbation perturbation{.translation_m = 1.5, .rotation_deg = 3.0, .seed = 4};
  int left_turns = 0;
  std::set<double> directions;
  for (std::uint64_t query = 0; query < 50; ++query) {
    const Pose3 pose = Perturb(Truth(), perturbation, "scene", query).T_map_vehicle;
    const Eigen::Vector3d moved = pose.translation_m - Truth().translation_m;
    EXPECT_NEAR(moved.norm(), 1.5, 1e-12);
    EXPECT_EQ(moved.z(), 0.0);
    directions.insert(std::atan2(moved.y(), moved.x()));
    const double turned_deg =
        WrapAngle(Yaw(pose.rotation) - Yaw(Truth().rotation)) * 180.0 / std::numbers::pi;
    EXPECT_NEAR(std::abs(turned_deg), 3.0, 1e-9);
    left_turns += turned_deg > 0.0 ? 1 : 0;
  }
  EXPECT_GT(left_turns, 10);
  EXPECT_LT(left_turns, 40);
  EXPECT_EQ(directions.size(), 50U);
}

TEST(Perturb, DependsOnSeedDriveAndQueryAlone) {
  const auto x = [](std::uint64_t seed, const std::string& drive, std::uint64_t query) {
    return Perturb(Truth(), {.translation_m = 1.0, .rotation_deg = 2.0, .seed = seed}, drive, query)
        .T_map_vehicle.translation_m.x();
  };
  EXPECT_EQ(x(1, "a", 0), x(1, "a", 0));
  EXPECT_NE(x(1, "a", 0), x(2, "a", 0));
  EXPECT_NE(x(1, "a", 0), x(1, "b", 0));
  EXPECT_NE(x(1, "a", 0), x(1, "a", 1));
}

TEST(Perturb, OwnsUpToThePerturbation) {
  const Matrix6d covariance =
      Perturb(Truth(), {.translation_m = 1.0, .rotation_deg = 2.0, .seed = 1}, "a", 0).covariance;
  EXPECT_NEAR(covariance(0, 0) + covariance(1, 1), 1.0, 1e-12);
  EXPECT_NEAR(std::sqrt(covariance(5, 5)) * 180.0 / std::numbers::pi, 2.0, 1e-9);
  const Matrix6d exact =
      Perturb(Truth(), {.translation_m = 0.0, .rotation_deg = 0.0, .seed = 1}, "a", 0).covariance;
  EXPECT_GT(exact(0, 0), 0.0);
  EXPECT_GT(exact(5, 5), 0.0);
}

}  // namespace
}  // namespace dcloc
