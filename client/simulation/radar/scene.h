#pragma once

#include <map>
#include <utility>
#include <vector>

#include "client/simulation/world/parking.h"
#include "client/simulation/world/scatterer.h"
#include "client/simulation/world/world.h"

namespace dcloc::simulation {

/// Everything that stands still during one pass, found by place.
class Scene {
 public:
  Scene(const World& world, const std::vector<ParkedVehicle>& parked);

  /// Calls `visit` with every scatterer (or wall) within `radius_m` of `position`, and some beyond,
  /// in a fixed order.
  template <typename Visit>
  void VisitScatterers(const Eigen::Vector2d& position, double radius_m, const Visit& visit) const {
    VisitCells(position, radius_m, [&](const Cell& cell) {
      for (const std::size_t i : cell.scatterers) visit(scatterers_[i]);
    });
  }
  template <typename Visit>
  void VisitWalls(const Eigen::Vector2d& position, double radius_m, const Visit& visit) const {
    // A wall is filed under its middle.
    VisitCells(position, radius_m + 0.5 * longest_wall_m_, [&](const Cell& cell) {
      for (const std::size_t i : cell.walls) visit(walls_[i]);
    });
  }

 private:
  static constexpr double kCellSize = 25.0;  // [m]
  struct Cell {
    std::vector<std::size_t> scatterers;
    std::vector<std::size_t> walls;
  };
  using CellKey = std::pair<int, int>;

  static CellKey KeyOf(const Eigen::Vector2d& position);
  void AddParked(const ParkedVehicle& parked);
  void BuildIndex();

  template <typename Visit>
  void VisitCells(const Eigen::Vector2d& position, double radius_m, const Visit& visit) const {
    const auto [x_min, y_min] = KeyOf(position - Eigen::Vector2d::Constant(radius_m));
    const auto [x_max, y_max] = KeyOf(position + Eigen::Vector2d::Constant(radius_m));
    for (int x = x_min; x <= x_max; ++x) {
      const auto end = cells_.upper_bound({x, y_max});
      for (auto cell = cells_.lower_bound({x, y_min}); cell != end; ++cell) visit(cell->second);
    }
  }

  std::vector<Scatterer> scatterers_;
  std::vector<Wall> walls_;
  double longest_wall_m_ = 0.0;
  std::map<CellKey, Cell> cells_;
};

}  // namespace dcloc::simulation
