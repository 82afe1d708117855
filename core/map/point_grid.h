#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"

namespace dcloc {

/// Points in the plane, hashed by square cells, found by box. Points are numbered as inserted.
class PointGrid {
 public:
  explicit PointGrid(double cell_m) : cell_m_(cell_m) {}

  /// The number of the new point.
  std::uint32_t Insert(const Eigen::Vector2d& position_m) {
    const auto number = static_cast<std::uint32_t>(next_.size());
    std::uint32_t& head = heads_.try_emplace(CellOf(position_m), kEnd).first->second;
    next_.push_back(head);
    head = number;
    return number;
  }

  /// Calls visit(number) for all points in the cells that the box touches, in an order that depends
  /// on the insertions alone.
  template <typename Visit>
  void ForEachNear(const Eigen::Vector2d& center_m, const Eigen::Vector2d& half_size_m,
                   const Visit& visit) const {
    const auto [min_x, min_y] = CellOf(center_m - half_size_m);
    const auto [max_x, max_y] = CellOf(center_m + half_size_m);
    for (std::int64_t x = min_x; x <= max_x; ++x) {
      for (std::int64_t y = min_y; y <= max_y; ++y) {
        const auto head = heads_.find(Cell(x, y));
        if (head == heads_.end()) continue;
        for (std::uint32_t i = head->second; i != kEnd; i = next_[i]) visit(i);
      }
    }
  }

 private:
  using Cell = std::pair<std::int64_t, std::int64_t>;
  static constexpr std::uint32_t kEnd = 0xFFFFFFFF;

  Cell CellOf(const Eigen::Vector2d& position_m) const {
    return {static_cast<std::int64_t>(std::floor(position_m.x() / cell_m_)),
            static_cast<std::int64_t>(std::floor(position_m.y() / cell_m_))};
  }

  double cell_m_;
  absl::flat_hash_map<Cell, std::uint32_t> heads_;  ///< the point inserted last into each cell
  std::vector<std::uint32_t> next_;  ///< of each point, the one inserted before it into its cell
};

}  // namespace dcloc
