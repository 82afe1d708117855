#include "core/registration/rigid_ransac.h"

#include <cassert>
#include <cmath>
#include <random>

namespace dcloc {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2f;

// The motion that lays b1 on a1 and turns b1-b2 into the direction of a1-a2.
Pose2 FromTwoPairs(const Vector2d& a1, const Vector2d& a2, const Vector2d& b1, const Vector2d& b2) {
  const Vector2d da = a2 - a1;
  const Vector2d db = b2 - b1;
  Pose2 T_a_b;
  T_a_b.yaw_rad = WrapAngle(std::atan2(da.y(), da.x()) - std::atan2(db.y(), db.x()));
  T_a_b.translation_m = 0.5 * (a1 + a2) - T_a_b.Rotation() * (0.5 * (b1 + b2));
  return T_a_b;
}

std::vector<IndexPair> InliersOf(std::span<const Vector2f> a, std::span<const Vector2f> b,
                                 std::span<const IndexPair> pairs, const Pose2& T_a_b,
                                 double distance_m) {
  const Eigen::Matrix2f R = T_a_b.Rotation().cast<float>();
  const Vector2f t = T_a_b.translation_m.cast<float>();
  const auto limit = static_cast<float>(distance_m * distance_m);
  std::vector<IndexPair> inliers;
  for (const IndexPair& pair : pairs) {
    if ((a[pair.a] - (R * b[pair.b] + t)).squaredNorm() <= limit) inliers.push_back(pair);
  }
  return inliers;
}

// Least squares (Umeyama in the plane).
Pose2 FitRigid(std::span<const Vector2f> a, std::span<const Vector2f> b,
               std::span<const IndexPair> pairs) {
  Vector2d mean_a = Vector2d::Zero();
  Vector2d mean_b = Vector2d::Zero();
  for (const IndexPair& pair : pairs) {
    mean_a += a[pair.a].cast<double>();
    mean_b += b[pair.b].cast<double>();
  }
  mean_a /= static_cast<double>(pairs.size());
  mean_b /= static_cast<double>(pairs.size());
  double cosine = 0.0;
  double sine = 0.0;
  for (const IndexPair& pair : pairs) {
    const Vector2d da = a[pair.a].cast<double>() - mean_a;
    const Vector2d db = b[pair.b].cast<double>() - mean_b;
    cosine += db.dot(da);
    sine += db.x() * da.y() - db.y() * da.x();
  }
  Pose2 T_a_b{.yaw_rad = std::atan2(sine, cosine)};
  T_a_b.translation_m = mean_a - T_a_b.Rotation() * mean_b;
  return T_a_b;
}

}  // namespace

std::span<const OptionField<RigidRansacOptions>> FieldsOf(const RigidRansacOptions& /*options*/) {
  using O = RigidRansacOptions;
  static constexpr OptionField<O> kFields[] = {
      {"iterations", &O::iterations, 1, 1'000'000},
      {"inlier_distance_m", &O::inlier_distance_m, 0.01, 100},
      {"min_baseline_m", &O::min_baseline_m, 0.01, 1000},
      {"min_inlier_count", &O::min_inlier_count, 2, 1'000'000},
  };
  return kFields;
}

absl::Status Validate(const RigidRansacOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

std::optional<RigidMatch> MatchRigid(std::span<const Vector2f> a, std::span<const Vector2f> b,
                                     std::span<const IndexPair> pairs, std::uint64_t seed,
                                     const RigidRansacOptions& options) {
  assert(Validate(options).ok());
  if (pairs.size() < 2) return std::nullopt;
  std::mt19937_64 random(seed);
  std::uniform_int_distribution<std::size_t> pick(0, pairs.size() - 1);
  RigidMatch best;
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    const IndexPair& first = pairs[pick(random)];
    const IndexPair& second = pairs[pick(random)];
    const double length_a_m = (a[first.a] - a[second.a]).norm();
    const double length_b_m = (b[first.b] - b[second.b]).norm();
    if (std::min(length_a_m, length_b_m) < options.min_baseline_m) continue;
    if (std::abs(length_a_m - length_b_m) > 2.0 * options.inlier_distance_m) continue;
    const Pose2 T_a_b = FromTwoPairs(a[first.a].cast<double>(), a[second.a].cast<double>(),
                                     b[first.b].cast<double>(), b[second.b].cast<double>());
    std::vector<IndexPair> inliers = InliersOf(a, b, pairs, T_a_b, options.inlier_distance_m);
    if (inliers.size() > best.inliers.size()) best = {T_a_b, std::move(inliers)};
  }
  const auto min_inlier_count = static_cast<std::size_t>(options.min_inlier_count);
  if (best.inliers.empty() || best.inliers.size() < min_inlier_count) return std::nullopt;
  best.T_a_b = FitRigid(a, b, best.inliers);
  best.inliers = InliersOf(a, b, pairs, best.T_a_b, options.inlier_distance_m);
  // The fit may lose what the hypothesis held.
  if (best.inliers.size() < min_inlier_count) return std::nullopt;
  return best;
}

}  // namespace dcloc
