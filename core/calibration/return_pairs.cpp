#include "core/calibration/return_pairs.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/container/flat_hash_map.h"

namespace dcloc {
namespace {

using Cell = std::pair<std::int64_t, std::int64_t>;

Cell CellOf(const Eigen::Vector2d& position_m, double cell_m) {
  return {static_cast<std::int64_t>(std::floor(position_m.x() / cell_m)),
          static_cast<std::int64_t>(std::floor(position_m.y() / cell_m))};
}

bool SameStand(const ScanGeometry& a, const ScanGeometry& b) {
  return a.radar == b.radar && a.stand == b.stand;
}

}  // namespace

std::vector<ReturnPair> FindPairs(const FrameReturns& frame, double max_pair_distance_m,
                                  std::size_t max_per_return) {
  const std::vector<StaticReturn>& returns = frame.returns;
  absl::flat_hash_map<Cell, std::vector<std::uint32_t>> cells;
  for (std::uint32_t i = 0; i < returns.size(); ++i) {
    cells[CellOf(returns[i].position_m, max_pair_distance_m)].push_back(i);
  }
  std::vector<ReturnPair> pairs;
  std::vector<std::uint32_t> near;
  const auto collect = [&](std::uint32_t i, Cell at) {
    const auto cell = cells.find(at);
    if (cell == cells.end()) return;
    for (const std::uint32_t j : cell->second) {
      if (j <= i) continue;  // each pair once
      if (SameStand(frame.scans[returns[i].scan], frame.scans[returns[j].scan])) continue;
      const double distance_m = (returns[j].position_m - returns[i].position_m).norm();
      if (distance_m < max_pair_distance_m) near.push_back(j);
    }
  };
  for (std::uint32_t i = 0; i < returns.size(); ++i) {
    near.clear();
    const auto [x, y] = CellOf(returns[i].position_m, max_pair_distance_m);
    for (const std::int64_t dx : {-1, 0, 1}) {
      for (const std::int64_t dy : {-1, 0, 1}) collect(i, {x + dx, y + dy});
    }
    // An even choice, which favours no radar and no time.
    const std::size_t count = std::min(near.size(), max_per_return);
    for (std::size_t k = 0; k < count; ++k) {
      pairs.push_back({.first = i, .second = near[k * near.size() / count]});
    }
  }
  return pairs;
}

}  // namespace dcloc
