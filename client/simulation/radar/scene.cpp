#include "client/simulation/radar/scene.h"

#include <algorithm>
#include <cmath>

namespace dcloc::simulation {

Scene::Scene(const World& world, const std::vector<ParkedVehicle>& parked)
    : scatterers_(world.scatterers), walls_(world.walls) {
  for (const ParkedVehicle& vehicle : parked) AddParked(vehicle);
  BuildIndex();
}

Scene::CellKey Scene::KeyOf(const Eigen::Vector2d& position) {
  return {static_cast<int>(std::floor(position.x() / kCellSize)),
          static_cast<int>(std::floor(position.y() / kCellSize))};
}

void Scene::AddParked(const ParkedVehicle& parked) {
  for (Scatterer scatterer : parked.vehicle.scatterers) {
    scatterer.position_m = Embed(parked.T_map_body) * scatterer.position_m;
    scatterer.facing_rad += parked.T_map_body.yaw_rad;
    scatterers_.push_back(scatterer);
  }
  for (const Wall& side : Outline(parked.vehicle, parked.T_map_body)) walls_.push_back(side);
}

void Scene::BuildIndex() {
  for (std::size_t i = 0; i < scatterers_.size(); ++i) {
    cells_[KeyOf(scatterers_[i].position_m.head<2>())].scatterers.push_back(i);
  }
  for (std::size_t i = 0; i < walls_.size(); ++i) {
    const Wall& wall = walls_[i];
    cells_[KeyOf(0.5 * (wall.begin_m + wall.end_m))].walls.push_back(i);
    longest_wall_m_ = std::max(longest_wall_m_, (wall.end_m - wall.begin_m).norm());
  }
}

}  // namespace dcloc::simulation
