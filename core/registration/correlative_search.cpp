#include "core/registration/correlative_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dcloc {
namespace {

constexpr double kMaxLikelihood = 255.0;
constexpr double kSigma_cells = 1.4;

// Likelihoods at the offsets (column, row) from a landmark's cell, [0, reach]^2.
std::vector<std::uint8_t> Kernel(int reach) {
  std::vector<std::uint8_t> kernel;
  for (int row = 0; row <= reach; ++row) {
    for (int column = 0; column <= reach; ++column) {
      const double z = std::hypot(column, row) / kSigma_cells;
      kernel.push_back(static_cast<std::uint8_t>(kMaxLikelihood * std::exp(-0.5 * z * z)));
    }
  }
  return kernel;
}

double MedianRange(std::span<const Eigen::Vector2f> points) {
  std::vector<float> ranges;
  for (const Eigen::Vector2f& point : points) ranges.push_back(point.norm());
  const auto middle = ranges.begin() + static_cast<std::ptrdiff_t>(ranges.size() / 2);
  std::nth_element(ranges.begin(), middle, ranges.end());
  return *middle;
}

}  // namespace

template <int Dim>
LikelihoodField::LikelihoodField(const LocalMap<Dim>& map, double cell_m) : cell_m_(cell_m) {
  if (map.empty()) return;
  Eigen::Vector2d max_m = map.points().front().mean_m.template head<2>();
  min_m_ = max_m;
  for (const GaussianPoint<Dim>& point : map.points()) {
    min_m_ = min_m_.cwiseMin(point.mean_m.template head<2>());
    max_m = max_m.cwiseMax(point.mean_m.template head<2>());
  }
  const int reach = static_cast<int>(3.0 * kSigma_cells);
  // One cell more than the kernel reaches: rounding may put a point into the cell beside its own.
  min_m_.array() -= (reach + 1) * cell_m_;
  max_m.array() += (reach + 1) * cell_m_;
  columns_ = static_cast<int>((max_m.x() - min_m_.x()) / cell_m_) + 1;
  rows_ = static_cast<int>((max_m.y() - min_m_.y()) / cell_m_) + 1;
  cells_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), 0);

  const std::vector<std::uint8_t> kernel = Kernel(reach);
  for (const GaussianPoint<Dim>& point : map.points()) {
    const int column = static_cast<int>((point.mean_m.x() - min_m_.x()) / cell_m_);
    const int row = static_cast<int>((point.mean_m.y() - min_m_.y()) / cell_m_);
    for (int dy = -reach; dy <= reach; ++dy) {
      for (int dx = -reach; dx <= reach; ++dx) {
        std::uint8_t& cell =
            cells_[static_cast<std::size_t>(row + dy) * static_cast<std::size_t>(columns_) +
                   static_cast<std::size_t>(column + dx)];
        const auto k =
            static_cast<std::size_t>(std::abs(dy)) * static_cast<std::size_t>(reach + 1) +
            static_cast<std::size_t>(std::abs(dx));
        cell = std::max(cell, kernel[k]);
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

std::vector<PoseHypothesis> CorrelativeSearch(std::span<const Eigen::Vector2f> points,
                                              const LikelihoodField& field,
                                              const SearchWindow& window, int max_count) {
  if (points.empty() || field.empty() || max_count <= 0) return {};
  const double step_m = field.cell_m();
  const double step_rad = 2.0 * step_m / std::max(10.0, MedianRange(points));
  const double half_rad = std::min(window.rotation_rad, std::numbers::pi);
  const int turns = static_cast<int>(std::ceil(half_rad / step_rad));
  const int shifts = static_cast<int>(std::ceil(window.translation_m / step_m));

  std::vector<PoseHypothesis> all;
  const auto side = static_cast<std::size_t>(2 * shifts) + 1;
  all.reserve((static_cast<std::size_t>(2 * turns) + 1) * side * side);
  for (int turn = -turns; turn <= turns; ++turn) {
    for (int i = -shifts; i <= shifts; ++i) {
      for (int j = -shifts; j <= shifts; ++j) {
        Pose2 pose = window.centre_local_vehicle;
        pose.translation_m += step_m * Eigen::Vector2d(i, j);
        pose.yaw_rad = WrapAngle(pose.yaw_rad + turn * step_rad);
        all.push_back({pose, field.Score(points, pose)});
      }
    }
  }
  std::stable_sort(all.begin(), all.end(), [](const PoseHypothesis& a, const PoseHypothesis& b) {
    return a.score > b.score;
  });

  std::vector<PoseHypothesis> best;
  for (const PoseHypothesis& candidate : all) {
    const bool seen = std::any_of(best.begin(), best.end(), [&](const PoseHypothesis& kept) {
      const Pose2 apart = kept.T_local_vehicle.Inverse() * candidate.T_local_vehicle;
      return apart.translation_m.norm() < 4.0 * step_m && std::abs(apart.yaw_rad) < 4.0 * step_rad;
    });
    if (seen) continue;
    best.push_back(candidate);
    if (best.size() == static_cast<std::size_t>(max_count)) break;
  }
  return best;
}

template LikelihoodField::LikelihoodField(const LocalMap<2>& map, double cell_m);
template LikelihoodField::LikelihoodField(const LocalMap<3>& map, double cell_m);

}  // namespace dcloc
