#include "core/map/map_diff.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <tuple>

#include "core/map/map_edit.h"
#include "core/map/point_grid.h"

namespace dcloc {
namespace {

// All landmarks of a map, in one frame.
struct Landmarks {
  std::vector<LandmarkChange> all;
  std::vector<bool> is_covered;  ///< by the other map
  std::vector<bool> is_paired;
};

bool IsNearAny(const std::vector<Eigen::Vector2d>& positions_m, const PointGrid& grid,
               const Eigen::Vector2d& p, double radius_m) {
  bool found = false;
  grid.ForEachNear(p, Eigen::Vector2d::Constant(radius_m), [&](std::uint32_t i) {
    found = found || (positions_m[i] - p).norm() <= radius_m;
  });
  return found;
}

Pose3 PoseInMap(const MapParts& map, const KeyframeRecord& record, const Pose3& T_frame_map) {
  Pose3 T_map_keyframe = PoseOf(record);
  T_map_keyframe.translation_m += map.Origin_m();
  return T_frame_map * T_map_keyframe;
}

Landmarks LandmarksOf(const MapParts& map, const Pose3& T_frame_map, const MapParts& other,
                      const Pose3& T_frame_other, double covered_m) {
  std::vector<Eigen::Vector2d> keyframes_m;
  PointGrid grid(covered_m);
  for (const KeyframePart& keyframe : other.keyframes) {
    keyframes_m.emplace_back(
        PoseInMap(other, keyframe.record, T_frame_other).translation_m.head<2>());
    grid.Insert(keyframes_m.back());
  }
  Landmarks landmarks;
  for (const KeyframePart& keyframe : map.keyframes) {
    const Pose3 T_frame_keyframe = PoseInMap(map, keyframe.record, T_frame_map);
    for (const MapPoint& point : keyframe.points) {
      const Eigen::Vector3d p = T_frame_keyframe * PositionOf(point);
      landmarks.all.push_back({p, point.rcs_dbsm, point.scan_count, point.pass_count});
      landmarks.is_covered.push_back(IsNearAny(keyframes_m, grid, p.head<2>(), covered_m));
    }
  }
  landmarks.is_paired.assign(landmarks.all.size(), false);
  return landmarks;
}

// Calls pair(old, new, distance) for landmarks that are not paired yet, nearest first.
template <typename Pair>
void PairNearest(Landmarks& before, Landmarks& after, double radius_m, const Pair& pair) {
  PointGrid grid(radius_m);
  for (const LandmarkChange& landmark : after.all) grid.Insert(landmark.p_map.head<2>());
  std::vector<std::tuple<double, std::uint32_t, std::uint32_t>> candidates;
  for (std::uint32_t i = 0; i < before.all.size(); ++i) {
    if (before.is_paired[i]) continue;
    const Eigen::Vector2d p = before.all[i].p_map.head<2>();
    grid.ForEachNear(p, Eigen::Vector2d::Constant(radius_m), [&](std::uint32_t k) {
      const double distance_m = (after.all[k].p_map.head<2>() - p).norm();
      if (!after.is_paired[k] && distance_m <= radius_m) candidates.emplace_back(distance_m, i, k);
    });
  }
  std::ranges::sort(candidates);
  for (const auto& [distance_m, i, k] : candidates) {
    if (before.is_paired[i] || after.is_paired[k]) continue;
    before.is_paired[i] = after.is_paired[k] = true;
    pair(before.all[i], after.all[k], distance_m);
  }
}

// Those left over; gives how many lie where the other map covers nothing.
std::size_t TakeRest(const Landmarks& landmarks, std::vector<LandmarkChange>& changes) {
  std::size_t uncovered_count = 0;
  for (std::size_t i = 0; i < landmarks.all.size(); ++i) {
    if (landmarks.is_paired[i]) continue;
    if (landmarks.is_covered[i]) {
      changes.push_back(landmarks.all[i]);
    } else {
      ++uncovered_count;
    }
  }
  return uncovered_count;
}

}  // namespace

std::span<const OptionField<MapDiffOptions>> FieldsOf(const MapDiffOptions& /*options*/) {
  using O = MapDiffOptions;
  static constexpr OptionField<O> kFields[] = {
      {"same_m", &O::same_m, 0.001, 10},
      {"moved_m", &O::moved_m, 0.001, 20},
      {"covered_m", &O::covered_m, 1, 2000},
  };
  return kFields;
}

absl::Status Validate(const MapDiffOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

absl::StatusOr<MapDiff> Compare(const MapParts& old_map, const MapParts& new_map,
                                const MapDiffOptions& options) {
  if (absl::Status status = Validate(options); !status.ok()) return status;
  MapDiff diff;
  if (old_map.Anchor() && new_map.Anchor()) {
    diff.T_old_new = FrameChange(*old_map.Anchor(), *new_map.Anchor());
  }
  Landmarks before = LandmarksOf(old_map, {}, new_map, diff.T_old_new, options.covered_m);
  Landmarks after = LandmarksOf(new_map, diff.T_old_new, old_map, {}, options.covered_m);
  double sum_m2 = 0.0;
  PairNearest(before, after, options.same_m,
              [&](const LandmarkChange& old_one, const LandmarkChange&, double distance_m) {
                diff.same.push_back(old_one);
                sum_m2 += distance_m * distance_m;
              });
  if (!diff.same.empty()) {
    diff.same_rms_m = std::sqrt(sum_m2 / static_cast<double>(diff.same.size()));
  }
  PairNearest(before, after, std::max(options.moved_m, options.same_m),
              [&](const LandmarkChange& old_one, const LandmarkChange& new_one, double) {
                diff.moved.push_back({old_one, new_one});
              });
  diff.only_old_covers_count = TakeRest(before, diff.went);
  diff.only_new_covers_count = TakeRest(after, diff.came);
  return diff;
}

}  // namespace dcloc
