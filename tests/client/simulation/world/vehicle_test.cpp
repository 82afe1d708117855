#include "client/simulation/world/vehicle.h"

#include <gtest/gtest.h>

#include <numbers>

namespace dcloc::simulation {
namespace {

TEST(VehicleTest, ScatterersLieOnTheVehicle) {
  Random random = MakeRandom(3, Stream::kVehicle);
  int trucks = 0;
  for (int i = 0; i < 300; ++i) {
    const Vehicle vehicle = MakeVehicle(random, 0.2);
    trucks += vehicle.height_m >= 3.0 ? 1 : 0;
    ASSERT_GE(vehicle.scatterers.size(), 10U);
    for (const Scatterer& scatterer : vehicle.scatterers) {
      EXPECT_LE(std::abs(scatterer.position_m.x()), 0.5 * vehicle.length_m);
      EXPECT_LE(std::abs(scatterer.position_m.y()), 0.5 * vehicle.width_m);
      EXPECT_GT(scatterer.position_m.z(), 0.0);
      EXPECT_LE(scatterer.position_m.z(), vehicle.height_m);
    }
  }
  EXPECT_NEAR(trucks, 60, 30);  // more than four standard deviations
}

TEST(VehicleTest, ItsSidesCloseAroundIt) {
  const Vehicle vehicle{.length_m = 4.0, .width_m = 2.0, .height_m = 1.5, .scatterers = {}};
  const auto sides = Outline(vehicle, Pose2{{10.0, 5.0}, 0.5 * std::numbers::pi});
  for (std::size_t i = 0; i < sides.size(); ++i) {
    EXPECT_TRUE(sides[i].end_m.isApprox(sides[(i + 1) % 4].begin_m));
    EXPECT_LT(sides[i].loss_db, kOpaqueDb);  // some power passes
  }
  // Turned to the left: its front left corner is 2 m ahead along y and 1 m back along x.
  EXPECT_TRUE(sides[0].begin_m.isApprox(Eigen::Vector2d(9.0, 7.0)));
}

}  // namespace
}  // namespace dcloc::simulation
