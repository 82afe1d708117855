#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/gaussian_point.h"
#include "core/geometry/pose.h"
#include "core/map/packed_lanes.h"
#include "core/map/packed_point.h"
#include "core/map/radar_map.h"

namespace dcloc {

/// The landmarks around one place, in the frame of the nearest keyframe: the target of
/// registrations. The landmarks of several keyframes are joined, so that a place is seen from all
/// of its sides. In the plane (Dim = 2) the landmarks are projected onto the keyframe's xy plane.
template <int Dim>
class LocalMap {
 public:
  /// Memory that is needed only while a local map is made; reused for the next one.
  struct Workspace {
    std::vector<std::size_t> keyframes;
    std::vector<PackedPoint<Dim>> points;
    std::vector<std::uint32_t> cells;
  };

  LocalMap() = default;

  /// The landmarks within `radius_m` of the keyframe nearest to `p_map`; empty when the map has no
  /// keyframe within `radius_m` of `p_map`.
  LocalMap(const RadarMap& map, const Eigen::Vector3d& p_map, double radius_m);

  /// Replaces this local map by that one, and reuses its memory.
  void MoveTo(const RadarMap& map, const Eigen::Vector3d& p_map, double radius_m,
              Workspace& workspace);

  /// A local map of points in the local frame.
  LocalMap(const Pose3& T_map_local, const std::vector<GaussianPoint<Dim>>& points);

  bool empty() const { return point_count_ == 0; }
  const Pose3& T_map_local() const { return T_map_local_; }

  /// The points, ordered by cell.
  std::span<const PackedPoint<Dim>> points() const {
    return std::span(points_).first(point_count_);
  }

  /// The point at `index` and those that follow it; after the last one, points without a meaning.
  PackedLanes<Dim> LanesFrom(std::size_t index) const { return PackedLanes<Dim>(&points_[index]); }

  /// Calls `visit(index)` for every point in the cells that touch the square of half-width
  /// `reach_m` around (x, y) of the local frame.
  template <typename Visit>
  void ForEachNear(double x_m, double y_m, double reach_m, const Visit& visit) const {
    ForEachRunNear(x_m, y_m, reach_m, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) visit(i);
    });
  }

  /// The same by runs of points that follow each other: calls `visit(begin, end)`.
  template <typename Visit>
  void ForEachRunNear(double x_m, double y_m, double reach_m, const Visit& visit) const {
    if (empty()) return;
    const int column_begin = ClampedCell((x_m - reach_m - min_m_.x()) / kColumn_m, columns_);
    const int column_end = ClampedCell((x_m + reach_m - min_m_.x()) / kColumn_m, columns_);
    const int row_begin = ClampedCell((y_m - reach_m - min_m_.y()) / kRow_m, rows_);
    const int row_end = ClampedCell((y_m + reach_m - min_m_.y()) / kRow_m, rows_);
    for (int row = row_begin; row <= row_end; ++row) {
      // Cells of a row are neighbours in memory: one run of points.
      const std::size_t cell = static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_);
      visit(cell_begin_[cell + static_cast<std::size_t>(column_begin)],
            cell_begin_[cell + static_cast<std::size_t>(column_end) + 1]);
    }
  }

 private:
  // Rows are wide: a square around a point touches few of them, and each is a loop of its own over
  // a few points.
  static constexpr double kColumn_m = 1.0;
  static constexpr double kRow_m = 5.0;

  void BuildGrid(std::span<const PackedPoint<Dim>> points, std::vector<std::uint32_t>& cells);
  static int ClampedCell(double cell, int count) {
    if (!(cell > 0.0)) return 0;  // also what is not a number
    return static_cast<int>(std::min(cell, static_cast<double>(count - 1)));
  }

  Pose3 T_map_local_;
  std::vector<PackedPoint<Dim>> points_;  // and room after them, for lanes to be read from
  std::size_t point_count_ = 0;
  std::vector<std::uint32_t> cell_begin_;  // of each cell in points_, and twice the end
  Eigen::Vector2d min_m_ = Eigen::Vector2d::Zero();
  int columns_ = 0;
  int rows_ = 0;
};

}  // namespace dcloc
