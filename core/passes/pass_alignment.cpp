#include "core/passes/pass_alignment.h"

#include <Eigen/LU>
#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/map/point_grid.h"
#include "core/passes/landmark_refinement.h"
#include "core/passes/pass_centers.h"

namespace dcloc {
namespace {

// A center this many deviations from its landmark weighs half (Cauchy).
constexpr double kSoftSigmas = 1.5;
// A target is of the center that explains it best: 95 % of those of one scatterer, within reach.
constexpr double kOwnGate = 6.0;
constexpr double kOwnReach_m = 2.0;

/// A center and where its landmark lies beside it.
struct Offset {
  Eigen::Vector2d offset_m = Eigen::Vector2d::Zero();
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();  ///< zero where it has no landmark
};

std::vector<Offset> OffsetsOf(std::span<const LandmarkPosition> centers,
                              std::span<const LandmarkPosition> landmarks,
                              const CenterMatchingOptions& options, double shared_sigma_m) {
  const Eigen::Matrix2d shared_m2 = shared_sigma_m * shared_sigma_m * Eigen::Matrix2d::Identity();
  std::vector<Offset> offsets;
  const std::vector<CenterMatch> matches = MatchCenters(centers, landmarks, options);
  for (std::size_t c = 0; c < centers.size(); ++c) {
    Offset& offset = offsets.emplace_back();
    if (matches[c].center == kNoCenter) continue;
    const LandmarkPosition& landmark = landmarks[matches[c].center];
    offset.offset_m = landmark.position_m - centers[c].position_m;
    offset.information = (landmark.covariance_m2 + centers[c].covariance_m2 + shared_m2).inverse();
    const double squared = offset.offset_m.dot(offset.information * offset.offset_m);
    offset.information /= 1.0 + squared / (kSoftSigmas * kSoftSigmas);
  }
  return offsets;
}

/// Of each target of `scan` at `T_local_vehicle` the center that explains it best, without those
/// that no center explains.
std::vector<std::uint32_t> CentersSeen(const PlacedScan& scan, const Pose3& T_local_vehicle,
                                       std::span<const LandmarkPosition> centers,
                                       const PointGrid& grid) {
  std::vector<std::uint32_t> seen;
  const Eigen::Matrix3d R = T_local_vehicle.Rotation();
  for (const RadarPoint& point : scan.points) {
    const Eigen::Vector2d p_m = (T_local_vehicle * point.position_m).head<2>();
    const Eigen::Matrix2d noise = (R * point.covariance_m2 * R.transpose()).topLeftCorner<2, 2>();
    std::uint32_t best = kNoCenter;
    double best_squared = kOwnGate;
    grid.ForEachNear(p_m, Eigen::Vector2d::Constant(kOwnReach_m), [&](std::uint32_t c) {
      const Eigen::Vector2d offset_m = centers[c].position_m - p_m;
      const double squared = offset_m.dot((noise + centers[c].covariance_m2).inverse() * offset_m);
      if (squared >= best_squared) return;
      best_squared = squared;
      best = c;
    });
    if (best != kNoCenter) seen.push_back(best);
  }
  return seen;
}

/// What the offsets of the centers that each scan saw say of its pose. The scans that saw a center
/// share its offset.
std::vector<PosePull> PullsOf(const PlacedPass& pass, const std::vector<std::size_t>& scans,
                              const Eigen::Vector3d& origin_m,
                              std::span<const LandmarkPosition> centers,
                              std::span<const Offset> offsets) {
  PointGrid grid(1.0);
  for (const LandmarkPosition& center : centers) grid.Insert(center.position_m);
  std::vector<std::vector<std::uint32_t>> seen;
  std::vector<double> counts(centers.size(), 0.0);
  std::vector<Pose3> T_local_vehicles;
  for (const std::size_t i : scans) {
    T_local_vehicles.push_back(pass.scans[i].T_map_vehicle);
    T_local_vehicles.back().translation_m -= origin_m;
    seen.push_back(CentersSeen(pass.scans[i], T_local_vehicles.back(), centers, grid));
    for (const std::uint32_t c : seen.back()) counts[c] += 1.0;
  }
  std::vector<PosePull> pulls(scans.size());
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const Pose2 T_local_vehicle = Flatten(T_local_vehicles[i]);
    Eigen::Matrix<double, 2, 3> J;
    J.leftCols<2>() = T_local_vehicle.Rotation();
    for (const std::uint32_t c : seen[i]) {
      const Eigen::Vector2d arm_m = centers[c].position_m - T_local_vehicle.translation_m;
      J.col(2) << -arm_m.y(), arm_m.x();
      const Eigen::Matrix2d information = offsets[c].information / counts[c];
      pulls[i].information += J.transpose() * information * J;
      pulls[i].pull += J.transpose() * information * offsets[c].offset_m;
    }
  }
  return pulls;
}

}  // namespace

void AlignPass(const AlignmentTargets& targets, const Eigen::Vector3d& origin_m,
               const PassAlignmentOptions& options, PlacedPass& pass) {
  PassTrack track(pass, options.track);
  const auto place = [&] {
    for (std::size_t i = 0; i < track.scans().size(); ++i) {
      Pose3& T_map_vehicle = pass.scans[track.scans()[i]].T_map_vehicle;
      T_map_vehicle =
          T_map_vehicle * Embed(Flatten(T_map_vehicle).Inverse() * track.T_map_vehicles()[i]);
    }
  };
  if (track.scans().empty()) return;
  place();
  const auto align = [&](const CenterMatchingOptions& beyond_matching, double beyond_sigma_m) {
    const PlacedPass* const only = &pass;
    const std::vector<LandmarkPosition> centers =
        PositionsOf(FusePasses({&only, 1}, origin_m, options.min_center_scans));
    std::vector<Offset> offsets = OffsetsOf(centers, targets.landmarks, options.matching, 0.0);
    const std::vector<Offset> beyond =
        OffsetsOf(centers, targets.beyond_map, beyond_matching, beyond_sigma_m);
    for (std::size_t c = 0; c < centers.size(); ++c) {
      if (offsets[c].information.isZero()) offsets[c] = beyond[c];
    }
    track.Move(PullsOf(pass, track.scans(), origin_m, centers, offsets));
    place();
  };
  if (!targets.beyond_map.empty()) {
    for (const double sigma_m : options.beyond_pose_m) {
      align({.gate = options.matching.gate, .max_m = 3.0 * sigma_m, .pose_m = sigma_m}, sigma_m);
    }
  }
  for (int round = 0; round < options.rounds; ++round) align(options.matching, 0.0);
}

void AlignPasses(std::span<const PlacedLandmark> base, const Eigen::Vector3d& origin_m,
                 const PassAlignmentOptions& options, std::span<PlacedPass> passes) {
  std::vector<LandmarkPosition> positions = PositionsOf(base);
  std::vector<LandmarkPosition> beyond_map;
  std::vector<const PlacedPass*> all;
  for (PlacedPass& pass : passes) {
    AlignPass({positions, beyond_map}, origin_m, options, pass);
    all.push_back(&pass);
    const std::vector<LandmarkPosition> seen = PositionsOf(
        FusePasses({&all.back(), 1}, origin_m, options.min_center_scans, ScanChoice::kBeyondMap));
    beyond_map.insert(beyond_map.end(), seen.begin(), seen.end());
  }
  for (int round = 0; round < options.joint_rounds; ++round) {
    std::vector<Landmark> seen = FusePasses(all, origin_m, options.min_center_scans);
    std::erase_if(seen, [](const Landmark& landmark) { return landmark.pass_count < 2; });
    positions = BlendedPositions(base, seen, options.matching);
    PassAlignmentOptions once = options;
    once.rounds = 1;
    once.track.beyond_sigma_m = options.beyond_sigma_m;
    once.track.beyond_sigma_rad = options.beyond_sigma_rad;
    for (PlacedPass& pass : passes) AlignPass({positions, {}}, origin_m, once, pass);
  }
}

}  // namespace dcloc
