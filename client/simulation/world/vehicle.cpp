#include "client/simulation/world/vehicle.h"

#include <cmath>
#include <numbers>

#include "client/simulation/world/path.h"
#include "client/simulation/world/steps.h"

namespace dcloc::simulation {
namespace {

// Some power passes under and through the windows of a vehicle.
constexpr double kVehicleLossDb = 9.0;

class VehicleMaker {
 public:
  VehicleMaker(Random& random, Vehicle& vehicle) : random_(random), vehicle_(vehicle) {}

  void Add(double x, double y, double facing_rad, double half_sector_rad, double rcs_dbsm) {
    Scatterer scatterer;
    scatterer.position_m = {x, y, Uniform(random_, 0.3, std::min(1.2, vehicle_.height_m))};
    scatterer.rcs_dbsm = Normal(random_, rcs_dbsm, 3.0);
    scatterer.facing_rad = facing_rad;
    scatterer.half_sector_rad = half_sector_rad;
    scatterer.extent_m = 0.2;
    scatterer.id = static_cast<std::uint32_t>(random_());
    vehicle_.scatterers.push_back(scatterer);
  }

  void AddBody() {
    const double x = 0.5 * vehicle_.length_m - 0.1;
    const double y = 0.5 * vehicle_.width_m - 0.1;
    for (const double front : {1.0, -1.0}) {
      Add(front * x, 0.0, front > 0.0 ? 0.0 : std::numbers::pi, 1.2, 8.0);
      for (const double left : {1.0, -1.0}) {
        Add(front * x, left * y, std::atan2(left, front), 1.4, 5.0);
        Add(front * 0.62 * x, left * y, left * 0.5 * std::numbers::pi, 1.2, 3.0);
      }
    }
  }

  void AddSides(double spacing_m) {
    const double y = 0.5 * vehicle_.width_m - 0.05;
    for (const double x : Steps(-0.4 * vehicle_.length_m, 0.4 * vehicle_.length_m, spacing_m)) {
      Add(x, y, 0.5 * std::numbers::pi, 1.1, 4.0);
      Add(x, -y, -0.5 * std::numbers::pi, 1.1, 4.0);
    }
  }

 private:
  Random& random_;
  Vehicle& vehicle_;
};

}  // namespace

Vehicle MakeVehicle(Random& random, double truck_share) {
  Vehicle vehicle;
  VehicleMaker maker(random, vehicle);
  const double kind = Uniform(random, 0.0, 1.0);
  if (kind < truck_share) {
    vehicle = {Uniform(random, 8.0, 16.0), 2.5, Uniform(random, 3.0, 4.0), {}};
    maker.AddBody();
    maker.AddSides(1.7);
  } else if (kind < truck_share + 0.15) {
    vehicle = {Uniform(random, 5.0, 6.5), 2.0, Uniform(random, 2.0, 2.7), {}};
    maker.AddBody();
    maker.AddSides(2.2);
  } else {
    vehicle = {Uniform(random, 3.7, 4.9), Uniform(random, 1.7, 1.9), Uniform(random, 1.4, 1.7), {}};
    maker.AddBody();
  }
  return vehicle;
}

std::array<Wall, 4> Outline(const Vehicle& vehicle, const Pose2& T_map_body) {
  const double x = 0.5 * vehicle.length_m;
  const double y = 0.5 * vehicle.width_m;
  const std::array<Eigen::Vector2d, 4> corners = {
      T_map_body * Eigen::Vector2d(x, y), T_map_body * Eigen::Vector2d(-x, y),
      T_map_body * Eigen::Vector2d(-x, -y), T_map_body * Eigen::Vector2d(x, -y)};
  std::array<Wall, 4> sides;
  for (std::size_t i = 0; i < 4; ++i) {
    // A ray through the box crosses two sides.
    sides[i] = {corners[i], corners[(i + 1) % 4], vehicle.height_m, 0.5 * kVehicleLossDb, false};
  }
  return sides;
}

}  // namespace dcloc::simulation
