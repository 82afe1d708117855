#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/pose.h"
#include "core/map/local_map.h"

namespace dcloc {

/// How near each place of a local map's plane is to a landmark: exp(-d^2 / 2 sigma^2) of the
/// nearest one, on a grid. Cheap to look up, so that thousands of poses can be scored.
class LikelihoodField {
 public:
  LikelihoodField() = default;

  /// Cells of `cell_m`, sigma of 1.4 cells.
  template <int Dim>
  LikelihoodField(const LocalMap<Dim>& map, double cell_m);

  /// The same of landmarks at `positions_m`, in the box from `min_m` to `max_m`; others are left
  /// out.
  LikelihoodField(std::span<const Eigen::Vector2d> positions_m, double cell_m,
                  const Eigen::Vector2d& min_m, const Eigen::Vector2d& max_m);

  /// Mean likelihood of `points` (vehicle xy) at `T_local_vehicle`, in [0, 1].
  double Score(std::span<const Eigen::Vector2f> points, const Pose2& T_local_vehicle) const;

  bool empty() const { return cells_.empty(); }
  double cell_m() const { return cell_m_; }

  /// Where a position lies, in cells from the field's corner (column, row); rounded down it is the
  /// cell's index, which may lie outside of the field.
  Eigen::Vector2d CellsFrom(const Eigen::Vector2d& position_m) const {
    return (position_m - min_m_) / cell_m_;
  }
  /// Pointer to the likelihood of a cell of the field, where 255 is a landmark. The rest of its row
  /// follows; the next row begins `columns()` further.
  const std::uint8_t* At(const Eigen::Vector2i& cell) const {
    return &cells_[static_cast<std::size_t>(cell.y()) * static_cast<std::size_t>(columns_) +
                   static_cast<std::size_t>(cell.x())];
  }
  int columns() const { return columns_; }
  int rows() const { return rows_; }

 private:
  double cell_m_ = 1.0;
  Eigen::Vector2d min_m_ = Eigen::Vector2d::Zero();
  int columns_ = 0;
  int rows_ = 0;
  std::vector<std::uint8_t> cells_;  // 255 is a landmark
};

}  // namespace dcloc
