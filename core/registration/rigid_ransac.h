#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/geometry/pose.h"
#include "core/options/option_fields.h"
#include "core/registration/radial_statistics.h"

namespace dcloc {

struct RigidRansacOptions {
  int iterations = 2000;
  double inlier_distance_m = 0.8;
  double min_baseline_m = 4.0;  ///< two points nearer to one another give no heading
  int min_inlier_count = 6;
};
std::span<const OptionField<RigidRansacOptions>> FieldsOf(const RigidRansacOptions& options);

/// OK, or InvalidArgument that names the field, the value and the bound.
absl::Status Validate(const RigidRansacOptions& options);

/// A planar rigid motion and the pairs that follow it.
struct RigidMatch {
  Pose2 T_a_b;
  std::vector<IndexPair> inliers;
};

/// The motion `p_a = T_a_b p_b` that most of `pairs` agree on: RANSAC on two pairs at a time, whose
/// two distances must agree first, then least squares on the inliers. Nothing when too few agree.
/// The same input and `seed` give the same answer.
std::optional<RigidMatch> MatchRigid(std::span<const Eigen::Vector2f> a,
                                     std::span<const Eigen::Vector2f> b,
                                     std::span<const IndexPair> pairs, std::uint64_t seed,
                                     const RigidRansacOptions& options = {});

}  // namespace dcloc
