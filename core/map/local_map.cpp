#include "core/map/local_map.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace dcloc {
namespace {

Eigen::Matrix3d Covariance(const MapPoint& point) {
  Eigen::Matrix3d covariance;
  covariance << point.xx_m2, point.xy_m2, point.xz_m2,  //
      point.xy_m2, point.yy_m2, point.yz_m2,            //
      point.xz_m2, point.yz_m2, point.zz_m2;
  return covariance;
}

template <int Dim>
void AppendKeyframe(const Keyframe& keyframe, const Pose3& T_map_local, double radius_m,
                    std::vector<GaussianPoint<Dim>>& points) {
  const Pose3 T_local_keyframe = T_map_local.Inverse() * keyframe.T_map_keyframe;
  // Only the rows that are asked for: in the plane z is left behind.
  const Eigen::Matrix<double, Dim, 3> R = T_local_keyframe.Rotation().template topRows<Dim>();
  const Eigen::Matrix<double, Dim, 1> t = T_local_keyframe.translation_m.template head<Dim>();
  const double radius_m2 = radius_m * radius_m;
  for (const MapPoint& point : keyframe.points) {
    const Eigen::Matrix<double, Dim, 1> p_local =
        R * Eigen::Vector3d(point.x_m, point.y_m, point.z_m) + t;
    // Written so that a damaged file's NaN is left out too.
    if (!(p_local.template head<2>().squaredNorm() <= radius_m2)) continue;
    points.push_back({.mean_m = p_local, .covariance_m2 = R * Covariance(point) * R.transpose()});
  }
}

}  // namespace

template <int Dim>
LocalMap<Dim>::LocalMap(const RadarMap& map, const Eigen::Vector3d& p_map, double radius_m) {
  const std::optional<std::size_t> nearest = map.NearestKeyframe(p_map, radius_m);
  if (!nearest) return;
  T_map_local_ = map.keyframe(*nearest).T_map_keyframe;
  // A landmark belongs to the keyframe nearest to it, which therefore is no further from it than
  // this one is.
  const std::vector<std::size_t> around =
      map.KeyframesWithin(T_map_local_.translation_m, 2.0 * radius_m);
  std::size_t point_count = 0;
  for (const std::size_t index : around) point_count += map.keyframe(index).points.size();
  points_.reserve(point_count);
  for (const std::size_t index : around) {
    AppendKeyframe<Dim>(map.keyframe(index), T_map_local_, radius_m, points_);
  }
  BuildGrid();
}

template <int Dim>
LocalMap<Dim>::LocalMap(const Pose3& T_map_local, std::vector<Point> points)
    : T_map_local_(T_map_local), points_(std::move(points)) {
  BuildGrid();
}

// Counting sort of the points by cell.
template <int Dim>
void LocalMap<Dim>::BuildGrid() {
  if (points_.empty()) return;
  Eigen::Vector2d max_m = points_.front().mean_m.template head<2>();
  min_m_ = max_m;
  for (const Point& point : points_) {
    min_m_ = min_m_.cwiseMin(point.mean_m.template head<2>());
    max_m = max_m.cwiseMax(point.mean_m.template head<2>());
  }
  columns_ = static_cast<int>((max_m.x() - min_m_.x()) / kCell_m) + 1;
  rows_ = static_cast<int>((max_m.y() - min_m_.y()) / kCell_m) + 1;
  cell_begin_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) + 1, 0);
  std::vector<std::size_t> cells;  // of each point
  cells.reserve(points_.size());
  for (const Point& point : points_) {
    cells.push_back(static_cast<std::size_t>(ClampedCell(point.mean_m.y() - min_m_.y(), rows_)) *
                        static_cast<std::size_t>(columns_) +
                    static_cast<std::size_t>(ClampedCell(point.mean_m.x() - min_m_.x(), columns_)));
    ++cell_begin_[cells.back() + 1];
  }
  for (std::size_t cell = 1; cell < cell_begin_.size(); ++cell) {
    cell_begin_[cell] += cell_begin_[cell - 1];
  }
  std::vector<std::uint32_t> next(cell_begin_.begin(), cell_begin_.end() - 1);
  std::vector<Point> sorted(points_.size());
  for (std::size_t i = 0; i < points_.size(); ++i) sorted[next[cells[i]]++] = points_[i];
  points_ = std::move(sorted);
}

template class LocalMap<2>;
template class LocalMap<3>;

}  // namespace dcloc
