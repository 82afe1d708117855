#include "core/map/local_map.h"

#include <algorithm>
#include <cmath>
#include <optional>

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
void AppendKeyframe(const Keyframe& keyframe, bool has_heights, const Pose3& T_map_local,
                    double radius_m, std::vector<PackedPoint<Dim>>& points) {
  const Pose3 T_local_keyframe = T_map_local.Inverse() * keyframe.T_map_keyframe;
  // Only the rows that are asked for: in the plane z is left behind.
  const Eigen::Matrix<double, Dim, 3> R = T_local_keyframe.Rotation().template topRows<Dim>();
  const Eigen::Matrix<double, Dim, 1> t = T_local_keyframe.translation_m.template head<Dim>();
  const double radius_m2 = radius_m * radius_m;
  for (const MapPoint& point : keyframe.points) {
    const Eigen::Matrix<double, Dim, 1> p_local =
        R * Eigen::Vector3d(point.x_m, point.y_m, has_heights ? 0.0F : point.z_m) + t;
    // Written so that a damaged file's NaN is left out too.
    if (!(p_local.template head<2>().squaredNorm() <= radius_m2)) continue;
    const double height_m = has_heights ? point.z_m : 0.0;
    points.push_back(PackedPoint<Dim>({.mean_m = p_local,
                                       .covariance_m2 = R * Covariance(point) * R.transpose(),
                                       .height_square_m2 = height_m * height_m}));
  }
}

// As many as asked for, their values not to be relied on; room for some more, as the next local map
// may be a little larger.
template <typename T>
void Resize(std::vector<T>& values, std::size_t count) {
  if (count > values.capacity()) {
    values.clear();
    values.reserve(count + count / 8);
  }
  values.resize(count);
}

}  // namespace

template <int Dim>
LocalMap<Dim>::LocalMap(const RadarMap& map, const Eigen::Vector3d& p_map, double radius_m) {
  Workspace workspace;
  MoveTo(map, p_map, radius_m, workspace);
}

template <int Dim>
LocalMap<Dim>::LocalMap(const Pose3& T_map_local, const std::vector<GaussianPoint<Dim>>& points)
    : T_map_local_(T_map_local) {
  Workspace workspace;
  BuildGrid(std::vector<PackedPoint<Dim>>(points.begin(), points.end()), workspace.cells);
}

template <int Dim>
void LocalMap<Dim>::MoveTo(const RadarMap& map, const Eigen::Vector3d& p_map, double radius_m,
                           Workspace& workspace) {
  auto& [keyframes, points, cells] = workspace;
  points.clear();
  T_map_local_ = {};
  if (const std::optional<std::size_t> nearest = map.NearestKeyframe(p_map, radius_m)) {
    T_map_local_ = map.keyframe(*nearest).T_map_keyframe;
    // A landmark belongs to the keyframe nearest to it, which therefore is no further from it than
    // this one is.
    map.KeyframesWithin(T_map_local_.translation_m, 2.0 * radius_m, keyframes);
    for (const std::size_t index : keyframes) {
      AppendKeyframe<Dim>(map.keyframe(index), map.info().has_heights, T_map_local_, radius_m,
                          points);
    }
  }
  BuildGrid(points, cells);
}

// Counting sort of the points by cell; `cells` lends its memory.
template <int Dim>
void LocalMap<Dim>::BuildGrid(std::span<const PackedPoint<Dim>> points,
                              std::vector<std::uint32_t>& cells) {
  point_count_ = points.size();
  Resize(points_, point_count_ + kLaneCount - 1);
  if (points.empty()) return;
  Eigen::Vector2f min_m = points.front().mean_m.template head<2>();
  Eigen::Vector2f max_m = min_m;
  for (const PackedPoint<Dim>& point : points) {
    min_m = min_m.cwiseMin(point.mean_m.template head<2>());
    max_m = max_m.cwiseMax(point.mean_m.template head<2>());
  }
  min_m_ = min_m.cast<double>();
  columns_ = static_cast<int>((max_m.x() - min_m.x()) / kColumn_m) + 1;
  rows_ = static_cast<int>((max_m.y() - min_m.y()) / kRow_m) + 1;
  // Counted two places further on: the sums are each next cell's begin while points are put into
  // place, and that of the cell itself once all are.
  const std::size_t cell_count =
      static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  Resize(cell_begin_, cell_count + 2);
  std::ranges::fill(cell_begin_, 0);
  cells.clear();
  cells.reserve(points.size());
  for (const PackedPoint<Dim>& point : points) {
    const int row = ClampedCell((point.mean_m.y() - min_m_.y()) / kRow_m, rows_);
    const int column = ClampedCell((point.mean_m.x() - min_m_.x()) / kColumn_m, columns_);
    const auto cell = static_cast<std::uint32_t>(row) * static_cast<std::uint32_t>(columns_) +
                      static_cast<std::uint32_t>(column);
    cells.push_back(cell);
    ++cell_begin_[cell + 2];
  }
  for (std::size_t cell = 2; cell < cell_begin_.size(); ++cell) {
    cell_begin_[cell] += cell_begin_[cell - 1];
  }
  for (std::size_t i = 0; i < points.size(); ++i) points_[cell_begin_[cells[i] + 1]++] = points[i];
}

template class LocalMap<2>;
template class LocalMap<3>;

}  // namespace dcloc
