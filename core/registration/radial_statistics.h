#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/options/option_fields.h"

namespace dcloc {

struct RadialStatisticsOptions {
  double bin_m = 1.0 / 3.0;
  double max_distance_m = 40.0;
};
std::span<const OptionField<RadialStatisticsOptions>> FieldsOf(
    const RadialStatisticsOptions& options);

/// OK, or InvalidArgument that names the field, the value and the bound.
absl::Status Validate(const RadialStatisticsOptions& options);

/// Radial statistics descriptor, rotation-invariant form (METHOD 5 C): one column a point, the
/// histogram of its distances to the other points in soft bins, scaled to [0, 1].
Eigen::MatrixXf RadialStatistics(std::span<const Eigen::Vector2f> points,
                                 const RadialStatisticsOptions& options = {});

/// Columns of `a` and of `b` that belong together.
struct IndexPair {
  std::size_t a;
  std::size_t b;
};

/// Pairs of columns of which each is among the other's `k` nearest (L2), ascending by `a`.
std::vector<IndexPair> MutualNearest(const Eigen::MatrixXf& a, const Eigen::MatrixXf& b, int k = 1);

}  // namespace dcloc
