#include "core/map/map_diff.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
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

Pose3 PoseInMap(const EditableMap& map, const KeyframeRecord& record, const Pose3& T_frame_map) {
  Pose3 T_map_keyframe = PoseOf(record);
  T_map_keyframe.translation_m += map.Origin_m();
  return T_frame_map * T_map_keyframe;
}

// The ground near a map's keyframes.
class Coverage {
 public:
  Coverage(const EditableMap& map, const Pose3& T_frame_map, double radius_m)
      : radius_m_(radius_m), grid_(radius_m) {
    for (const EditableKeyframe& keyframe : map.keyframes) {
      keyframes_m_.emplace_back(
          PoseInMap(map, keyframe.record, T_frame_map).translation_m.head<2>());
      grid_.Insert(keyframes_m_.back());
    }
  }

  bool Holds(const Eigen::Vector2d& p) {
    // Landmarks come along the way: the keyframe that covers one mostly covers the next.
    if (last_ && IsNear(*last_, p)) return true;
    last_.reset();
    grid_.ForEachNear(p, Eigen::Vector2d::Constant(radius_m_), [&](std::uint32_t i) {
      if (!last_ && IsNear(i, p)) last_ = i;
    });
    return last_.has_value();
  }

 private:
  bool IsNear(std::uint32_t i, const Eigen::Vector2d& p) const {
    return (keyframes_m_[i] - p).norm() <= radius_m_;
  }

  double radius_m_;
  PointGrid grid_;
  std::vector<Eigen::Vector2d> keyframes_m_;
  std::optional<std::uint32_t> last_;  ///< the keyframe that covered the last one
};

Landmarks LandmarksOf(const EditableMap& map, const Pose3& T_frame_map, Coverage of_other) {
  Landmarks landmarks;
  for (const EditableKeyframe& keyframe : map.keyframes) {
    const Pose3 T_frame_keyframe = PoseInMap(map, keyframe.record, T_frame_map);
    for (const MapPoint& point : keyframe.points) {
      const Eigen::Vector3d p = T_frame_keyframe * PositionOf(point);
      landmarks.all.push_back({p, point.rcs_dbsm, point.scan_count, point.pass_count});
      landmarks.is_covered.push_back(of_other.Holds(p.head<2>()));
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

absl::StatusOr<MapDiff> Compare(const EditableMap& old_map, const EditableMap& new_map,
                                const MapDiffOptions& options) {
  if (absl::Status status = Validate(options); !status.ok()) return status;
  MapDiff diff;
  if (old_map.Anchor() && new_map.Anchor()) {
    diff.T_old_new = FrameChange(*old_map.Anchor(), *new_map.Anchor());
  }
  Landmarks before = LandmarksOf(old_map, {}, {new_map, diff.T_old_new, options.covered_m});
  Landmarks after = LandmarksOf(new_map, diff.T_old_new, {old_map, {}, options.covered_m});
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
  diff.only_old_covers_count = TakeRest(before, diff.removed);
  diff.only_new_covers_count = TakeRest(after, diff.added);
  return diff;
}

}  // namespace dcloc
