#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"

namespace dcloc {

/// Points in the plane, in square cells, found by box. Points are numbered as inserted. Cells are
/// kept in square blocks, so that a box of many cells needs only a few look-ups in the hash table.
class PointGrid {
 public:
  explicit PointGrid(double cell_m) : cell_m_(cell_m) {}

  /// The number of the new point.
  std::uint32_t Insert(const Eigen::Vector2d& position_m) {
    const auto number = static_cast<std::uint32_t>(next_.size());
    const Cell cell = CellOf(position_m);
    const auto [found, is_new] =
        block_numbers_.try_emplace(BlockOf(cell), static_cast<std::uint32_t>(blocks_.size()));
    if (is_new) blocks_.emplace_back().fill(kEnd);
    std::uint32_t& head = blocks_[found->second][PlaceInBlock(cell.first, cell.second)];
    next_.push_back(head);
    head = number;
    return number;
  }

  /// Calls visit(number) for all points in the cells that the box touches, in an order that depends
  /// on the insertions alone.
  template <typename Visit>
  void ForEachNear(const Eigen::Vector2d& center_m, const Eigen::Vector2d& half_size_m,
                   const Visit& visit) const {
    const Cell min = CellOf(center_m - half_size_m);
    const Cell max = CellOf(center_m + half_size_m);
    const Cell min_block = BlockOf(min);
    const Cell max_block = BlockOf(max);
    for (std::int64_t block_x = min_block.first; block_x <= max_block.first; ++block_x) {
      for (std::int64_t block_y = min_block.second; block_y <= max_block.second; ++block_y) {
        const auto found = block_numbers_.find(Cell(block_x, block_y));
        if (found == block_numbers_.end()) continue;
        VisitBlock(blocks_[found->second], {block_x, block_y}, min, max, visit);
      }
    }
  }

 private:
  using Cell = std::pair<std::int64_t, std::int64_t>;
  static constexpr std::uint32_t kEnd = 0xFFFFFFFF;
  static constexpr std::int64_t kSide = 8;                 // cells of a block along x and along y
  using Block = std::array<std::uint32_t, kSide * kSide>;  // the point inserted last into each cell

  Cell CellOf(const Eigen::Vector2d& position_m) const {
    return {static_cast<std::int64_t>(std::floor(position_m.x() / cell_m_)),
            static_cast<std::int64_t>(std::floor(position_m.y() / cell_m_))};
  }

  // Shifts and masks round down for negative cells too.
  static Cell BlockOf(const Cell& cell) { return {cell.first >> 3, cell.second >> 3}; }
  static std::size_t PlaceInBlock(std::int64_t x, std::int64_t y) {
    return static_cast<std::size_t>((x & (kSide - 1)) * kSide + (y & (kSide - 1)));
  }

  // The cells of `block` from `min` to `max`.
  template <typename Visit>
  void VisitBlock(const Block& heads, const Cell& block, const Cell& min, const Cell& max,
                  const Visit& visit) const {
    const std::int64_t begin_x = std::max(min.first, block.first * kSide);
    const std::int64_t end_x = std::min(max.first + 1, (block.first + 1) * kSide);
    const std::int64_t begin_y = std::max(min.second, block.second * kSide);
    const std::int64_t end_y = std::min(max.second + 1, (block.second + 1) * kSide);
    for (std::int64_t x = begin_x; x < end_x; ++x) {
      for (std::int64_t y = begin_y; y < end_y; ++y) {
        for (std::uint32_t i = heads[PlaceInBlock(x, y)]; i != kEnd; i = next_[i]) visit(i);
      }
    }
  }

  double cell_m_;
  absl::flat_hash_map<Cell, std::uint32_t> block_numbers_;
  std::vector<Block> blocks_;
  std::vector<std::uint32_t> next_;  ///< of each point, the one inserted before it into its cell
};

}  // namespace dcloc
