#include "core/registration/likelihood_field.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace dcloc {
namespace {

constexpr double kMaxLikelihood = 255.0;  // of a byte
// A point between two cells loses a tenth of its likelihood: the grid does not show.
constexpr double kSigma_cells = 1.4;

// Likelihoods around a landmark's cell, up to `reach` cells away to each side, row by row.
std::vector<std::uint8_t> Kernel(int reach) {
  std::vector<std::uint8_t> kernel;
  for (int row = -reach; row <= reach; ++row) {
    for (int column = -reach; column <= reach; ++column) {
      const double z = std::hypot(column, row) / kSigma_cells;
      kernel.push_back(static_cast<std::uint8_t>(kMaxLikelihood * std::exp(-0.5 * z * z)));
    }
  }
  return kernel;
}

}  // namespace

template <int Dim>
LikelihoodField::LikelihoodField(const LocalMap<Dim>& map, double cell_m) {
  if (map.empty()) return;
  std::vector<Eigen::Vector2d> positions_m;
  positions_m.reserve(map.points().size());
  Eigen::Vector2d min_m = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d max_m = -min_m;
  for (const PackedPoint<Dim>& point : map.points()) {
    positions_m.emplace_back(point.mean_m.template head<2>().template cast<double>());
    min_m = min_m.cwiseMin(positions_m.back());
    max_m = max_m.cwiseMax(positions_m.back());
  }
  *this = LikelihoodField(positions_m, cell_m, min_m, max_m);
}

LikelihoodField::LikelihoodField(std::span<const Eigen::Vector2d> positions_m, double cell_m,
                                 const Eigen::Vector2d& min_m, const Eigen::Vector2d& max_m)
    : cell_m_(cell_m) {
  const int reach = static_cast<int>(3.0 * kSigma_cells);
  // One cell more than the kernel reaches: rounding may put a point into the cell beside its own.
  min_m_ = min_m.array() - (reach + 1) * cell_m_;
  const Eigen::Vector2d size_m = max_m.array() + (reach + 1) * cell_m_ - min_m_.array();
  columns_ = static_cast<int>(size_m.x() / cell_m_) + 1;
  rows_ = static_cast<int>(size_m.y() / cell_m_) + 1;
  cells_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), 0);

  const std::vector<std::uint8_t> kernel = Kernel(reach);
  const auto side = static_cast<std::size_t>(2 * reach) + 1;
  for (const Eigen::Vector2d& position_m : positions_m) {
    // Written so that what is not a number is left out too.
    if (!((position_m.array() >= min_m.array()).all() &&
          (position_m.array() <= max_m.array()).all())) {
      continue;
    }
    const Eigen::Vector2i centre = CellsFrom(position_m).cast<int>();
    for (std::size_t row = 0; row < side; ++row) {
      std::uint8_t* const cells = &cells_[(static_cast<std::size_t>(centre.y() - reach) + row) *
                                              static_cast<std::size_t>(columns_) +
                                          static_cast<std::size_t>(centre.x() - reach)];
      const std::uint8_t* const likelihoods = &kernel[row * side];
      for (std::size_t column = 0; column < side; ++column) {
        cells[column] = std::max(cells[column], likelihoods[column]);
      }
    }
  }
}

double LikelihoodField::Score(std::span<const Eigen::Vector2f> points,
                              const Pose2& T_local_vehicle) const {
  if (points.empty() || cells_.empty()) return 0.0;
  const auto per_cell = static_cast<float>(1.0 / cell_m_);
  const auto c = static_cast<float>(std::cos(T_local_vehicle.yaw_rad)) * per_cell;
  const auto s = static_cast<float>(std::sin(T_local_vehicle.yaw_rad)) * per_cell;
  const auto x = static_cast<float>(T_local_vehicle.translation_m.x() - min_m_.x()) * per_cell;
  const auto y = static_cast<float>(T_local_vehicle.translation_m.y() - min_m_.y()) * per_cell;
  const auto columns = static_cast<float>(columns_);
  const auto rows = static_cast<float>(rows_);
  std::uint64_t sum = 0;
  for (const Eigen::Vector2f& point : points) {
    const float column = c * point.x() - s * point.y() + x;
    const float row = s * point.x() + c * point.y() + y;
    if (!(column >= 0.0F && column < columns && row >= 0.0F && row < rows)) continue;
    sum += cells_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                  static_cast<std::size_t>(column)];
  }
  return static_cast<double>(sum) / (kMaxLikelihood * static_cast<double>(points.size()));
}

template LikelihoodField::LikelihoodField(const LocalMap<2>& map, double cell_m);
template LikelihoodField::LikelihoodField(const LocalMap<3>& map, double cell_m);

}  // namespace dcloc
