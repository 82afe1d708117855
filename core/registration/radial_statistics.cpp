#include "core/registration/radial_statistics.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>

namespace dcloc {
namespace {

void ScaleToUnit(Eigen::Ref<Eigen::VectorXf> histogram) {
  const float min = histogram.minCoeff();
  const float range = histogram.maxCoeff() - min;
  if (range > 0.0F) histogram = (histogram.array() - min) / range;
}

// For each column of `distances`, the rows of its k smallest values.
std::vector<std::vector<Eigen::Index>> NearestRows(const Eigen::MatrixXf& distances, int k) {
  std::vector<std::vector<Eigen::Index>> nearest;
  std::vector<Eigen::Index> rows(static_cast<std::size_t>(distances.rows()));
  const auto count = std::min<std::ptrdiff_t>(k, distances.rows());
  for (Eigen::Index column = 0; column < distances.cols(); ++column) {
    std::iota(rows.begin(), rows.end(), 0);
    std::partial_sort(rows.begin(), rows.begin() + count, rows.end(),
                      [&](Eigen::Index i, Eigen::Index j) {
                        const float di = distances(i, column);
                        const float dj = distances(j, column);
                        return di != dj ? di < dj : i < j;
                      });
    nearest.emplace_back(rows.begin(), rows.begin() + count);
  }
  return nearest;
}

}  // namespace

std::span<const OptionField<RadialStatisticsOptions>> FieldsOf(
    const RadialStatisticsOptions& /*options*/) {
  using O = RadialStatisticsOptions;
  static constexpr OptionField<O> kFields[] = {
      {"bin_m", &O::bin_m, 0.01, 100},
      {"max_distance_m", &O::max_distance_m, 0.1, 1000},
  };
  return kFields;
}

absl::Status Validate(const RadialStatisticsOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

Eigen::MatrixXf RadialStatistics(std::span<const Eigen::Vector2f> points,
                                 const RadialStatisticsOptions& options) {  // METHOD 5
  assert(Validate(options).ok());
  const auto bins = static_cast<Eigen::Index>(options.max_distance_m / options.bin_m) + 1;
  const auto count = static_cast<Eigen::Index>(points.size());
  Eigen::MatrixXf histograms = Eigen::MatrixXf::Zero(bins, count);
  const auto per_bin = static_cast<float>(1.0 / options.bin_m);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index j = i + 1; j < count; ++j) {
      const float at =
          per_bin *
          (points[static_cast<std::size_t>(i)] - points[static_cast<std::size_t>(j)]).norm();
      const auto bin = static_cast<Eigen::Index>(at);
      if (bin + 1 >= bins) continue;
      // Shared between the two bins around it, so that a small shift changes little.
      const float upper = at - static_cast<float>(bin);
      for (const Eigen::Index column : {i, j}) {
        histograms(bin, column) += 1.0F - upper;
        histograms(bin + 1, column) += upper;
      }
    }
  }
  for (Eigen::Index i = 0; i < count; ++i) ScaleToUnit(histograms.col(i));
  return histograms;
}

std::vector<IndexPair> MutualNearest(const Eigen::MatrixXf& a, const Eigen::MatrixXf& b, int k) {
  if (a.cols() == 0 || b.cols() == 0) return {};
  // |a - b|^2 for all pairs by one matrix product.
  Eigen::MatrixXf distances = -2.0F * a.transpose() * b;
  distances.colwise() += a.colwise().squaredNorm().transpose();
  distances.rowwise() += b.colwise().squaredNorm();
  const auto nearest_a = NearestRows(distances, k);              // of each b
  const auto nearest_b = NearestRows(distances.transpose(), k);  // of each a

  std::vector<IndexPair> pairs;
  for (std::size_t i = 0; i < nearest_b.size(); ++i) {
    for (const Eigen::Index j : nearest_b[i]) {
      const auto& back = nearest_a[static_cast<std::size_t>(j)];
      if (std::find(back.begin(), back.end(), static_cast<Eigen::Index>(i)) == back.end()) continue;
      pairs.push_back({i, static_cast<std::size_t>(j)});
    }
  }
  return pairs;
}

}  // namespace dcloc
