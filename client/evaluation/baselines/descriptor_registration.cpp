#include "client/evaluation/baselines/descriptor_registration.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "core/registration/radial_statistics.h"
#include "core/registration/rigid_ransac.h"

namespace dcloc {
namespace {

using Points = std::vector<Eigen::Vector2f>;

constexpr std::size_t kMaxLivePoints = 600;
constexpr std::size_t kMaxLandmarks = 1500;

// Every n-th, so that there are no more than `max_count`.
Points Thinned(const Points& points, std::size_t max_count) {
  const std::size_t stride = std::max<std::size_t>(1, (points.size() + max_count - 1) / max_count);
  Points thinned;
  for (std::size_t i = 0; i < points.size(); i += stride) thinned.push_back(points[i]);
  return thinned;
}

Points LivePoints(std::span<const GaussianPoint<2>> live) {
  Points points;
  for (const GaussianPoint<2>& point : live) points.emplace_back(point.mean_m.cast<float>());
  return Thinned(points, kMaxLivePoints);
}

// The landmarks near to where the prediction puts live points. A descriptor is a histogram of all
// that is around: what the radar did not look at would spoil it.
Points LandmarksInView(const LocalMap<2>& map, const Points& live, const Pose2& predicted) {
  constexpr double kCell_m = 3.0;
  const auto cell = [](const Eigen::Vector2d& p) {
    return std::pair(static_cast<int>(std::floor(p.x() / kCell_m)),
                     static_cast<int>(std::floor(p.y() / kCell_m)));
  };
  std::set<std::pair<int, int>> seen;
  for (const Eigen::Vector2f& point : live) {
    const auto [x, y] = cell(predicted * Eigen::Vector2d(point.cast<double>()));
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) seen.emplace(x + dx, y + dy);
    }
  }
  Points landmarks;
  for (const PackedPoint<2>& point : map.points()) {
    if (seen.contains(cell(point.mean_m.cast<double>()))) landmarks.push_back(point.mean_m);
  }
  return Thinned(landmarks, kMaxLandmarks);
}

// Leaves out pairs that the prediction, give or take `kReach_m` and `kTurn_rad`, does not bring
// together.
std::vector<IndexPair> NearPrediction(std::vector<IndexPair> pairs, const Points& landmarks,
                                      const Points& live, const Pose2& predicted) {
  constexpr double kReach_m = 3.0;
  constexpr double kTurn_rad = 0.1;
  std::erase_if(pairs, [&](const IndexPair& pair) {
    const Eigen::Vector2d p = live[pair.b].cast<double>();
    return (predicted * p - landmarks[pair.a].cast<double>()).norm() >
           kReach_m + kTurn_rad * p.norm();
  });
  return pairs;
}

}  // namespace

std::optional<PlanarFit> DescriptorRegistration::Register(std::span<const GaussianPoint<2>> live,
                                                          const LocalMap<2>& map,
                                                          const Pose2& predicted,
                                                          std::uint64_t seed) const {
  constexpr int kNeighbours = 2;
  constexpr int kMinInliers = 10;
  constexpr double kRansacError_m = 0.3;
  const Points points = LivePoints(live);
  const Points landmarks = LandmarksInView(map, points, predicted);
  const std::vector<IndexPair> pairs = NearPrediction(
      MutualNearest(RadialStatistics(landmarks), RadialStatistics(points), kNeighbours), landmarks,
      points, predicted);
  const std::optional<RigidMatch> rigid = MatchRigid(landmarks, points, pairs, seed);
  if (!rigid) return std::nullopt;
  if (!gicp_) {
    return PlanarFit{.T_local_vehicle = rigid->T_a_b,
                     .inlier_count = static_cast<int>(rigid->inliers.size())};
  }
  GicpOptions gicp = *gicp_;
  gicp.initial_blur_m = kRansacError_m;
  const Registration<2> refined = RegisterGicp<2>(live, map, rigid->T_a_b, gicp);
  if (refined.inlier_count < kMinInliers) return std::nullopt;
  return PlanarFit{.T_local_vehicle = refined.T_local_vehicle,
                   .covariance = refined.covariance,
                   .inlier_count = refined.inlier_count};
}

}  // namespace dcloc
