#include "core/map/map_edit.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <map>
#include <set>
#include <utility>

#include "absl/strings/str_format.h"
#include "core/map/map_content.h"
#include "core/map/point_grid.h"

namespace dcloc {
namespace {

using PoseBits = std::array<double, 7>;
using PointBits = std::array<std::byte, sizeof(MapPoint)>;

// What the smallest correction of a time offset leaves in a map (LearnedStampOptions).
constexpr double kMaxIgnoredStampDelay_s = 0.02;
constexpr double kDoubled_m = 0.4;  // FusionOptions::cell_m: nearer returns are one landmark

PoseBits BitsOf(const KeyframeRecord& record) {
  const auto& t = record.translation_local_m;
  const auto& q = record.rotation_wxyz;
  return {t[0], t[1], t[2], q[0], q[1], q[2], q[3]};
}

PointBits BitsOf(const MapPoint& point) { return std::bit_cast<PointBits>(point); }

bool IsOn(RegionSide side, const RegionTest& region, const Eigen::Vector3d& p_map) {
  return region.Holds(p_map.head<2>()) == (side == RegionSide::kInside);
}

// Of the street's length, what `part` of the keyframes stand for.
double ShareOfLength(const EditableMap& map, std::size_t part) {
  if (map.keyframes.empty()) return 0.0;
  return map.info.length_m * static_cast<double>(part) / static_cast<double>(map.keyframes.size());
}

// b's keyframe in a's file.
KeyframeRecord InFrameOf(const EditableMap& a, const EditableMap& b, const Pose3& T_a_b,
                         const KeyframeRecord& record) {
  const bool is_same =
      T_a_b.translation_m.isZero(0.0) && T_a_b.rotation.coeffs() == Pose3().rotation.coeffs();
  if (is_same && a.info.local_origin_m == b.info.local_origin_m) return record;
  Pose3 T_map_keyframe = PoseOf(record);
  T_map_keyframe.translation_m += b.Origin_m();
  if (!is_same) T_map_keyframe = T_a_b * T_map_keyframe;
  const Eigen::Vector3d t = T_map_keyframe.translation_m - a.Origin_m();
  const Eigen::Quaterniond q = T_map_keyframe.rotation.normalized();
  KeyframeRecord moved = record;
  moved.translation_local_m = {t.x(), t.y(), t.z()};
  moved.rotation_wxyz = {q.w(), q.x(), q.y(), q.z()};
  return moved;
}

// The landmarks of a map by position, to see what lies near.
class Near {
 public:
  explicit Near(const EditableMap& map) : grid_(kDoubled_m) {
    for (const EditableKeyframe& keyframe : map.keyframes) {
      const Pose3 T_local_keyframe = PoseOf(keyframe.record);
      for (const MapPoint& point : keyframe.points) {
        positions_m_.emplace_back((T_local_keyframe * PositionOf(point)).head<2>());
        grid_.Insert(positions_m_.back());
      }
    }
  }

  bool HasOne(const Eigen::Vector2d& p_local) const {
    bool found = false;
    grid_.ForEachNear(p_local, Eigen::Vector2d::Constant(kDoubled_m), [&](std::uint32_t i) {
      found = found || (positions_m_[i] - p_local).norm() < kDoubled_m;
    });
    return found;
  }

 private:
  PointGrid grid_;
  std::vector<Eigen::Vector2d> positions_m_;
};

}  // namespace

absl::StatusOr<EditableMap> KeepSide(const EditableMap& map, const PlanarRegion& region,
                                     RegionSide side) {
  if (absl::Status status = Validate(region); !status.ok()) return status;
  EditableMap kept{
      .info = map.info, .name = map.name, .description = map.description, .keyframes = {}};
  const RegionTest test(region);
  for (const EditableKeyframe& keyframe : map.keyframes) {
    Pose3 T_map_keyframe = PoseOf(keyframe.record);
    T_map_keyframe.translation_m += map.Origin_m();
    EditableKeyframe part{.record = keyframe.record, .points = {}};
    for (const MapPoint& point : keyframe.points) {
      if (IsOn(side, test, T_map_keyframe * PositionOf(point))) part.points.push_back(point);
    }
    if (part.points.empty() && !IsOn(side, test, T_map_keyframe.translation_m)) continue;
    kept.keyframes.push_back(std::move(part));
  }
  if (kept.PointCount() == 0) {
    return absl::FailedPreconditionError(
        absl::StrFormat("the region holds %s of the map's %d landmarks",
                        side == RegionSide::kInside ? "none" : "all", map.PointCount()));
  }
  kept.info.length_m = ShareOfLength(map, kept.keyframes.size());
  return kept;
}

Pose3 FrameChange(const GeodeticAnchor& anchor_a, const GeodeticAnchor& anchor_b) {
  const auto tied = [](const GeodeticAnchor& anchor) {
    return std::array{anchor.origin.latitude_deg, anchor.origin.longitude_deg,
                      anchor.origin.height_m, anchor.x_axis_east_rad};
  };
  if (tied(anchor_a) == tied(anchor_b)) return {};
  // Both frames are Cartesian, so that four points determine the whole change.
  constexpr double kArm_m = 1000.0;
  const auto in_a = [&](const Eigen::Vector3d& p_b) {
    return MapFromGeodetic(anchor_a, GeodeticFromMap(anchor_b, p_b));
  };
  const Eigen::Vector3d origin_a = in_a(Eigen::Vector3d::Zero());
  Eigen::Matrix3d axes;
  for (Eigen::Index i = 0; i < 3; ++i) {
    axes.col(i) = (in_a(kArm_m * Eigen::Vector3d::Unit(i)) - origin_a) / kArm_m;
  }
  return {.translation_m = origin_a, .rotation = Eigen::Quaterniond(axes).normalized()};
}

absl::Status CheckFrames(const EditableMap& a, const EditableMap& b, bool is_same_frame) {
  if (is_same_frame || (a.Anchor() && b.Anchor())) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrFormat(
      "the map \"%s\" has no anchor on the Earth, so it is not known where it lies in the frame of "
      "\"%s\"",
      a.Anchor() ? b.name : a.name, a.Anchor() ? a.name : b.name));
}

absl::StatusOr<EditableMap> Merge(const EditableMap& a, const EditableMap& b, MergeCounts& counts) {
  constexpr std::uint32_t kKind = kHasElevationFlag | kHasHeightsFlag;
  if ((a.info.flags & kKind) != (b.info.flags & kKind)) {
    return absl::FailedPreconditionError(absl::StrFormat(
        "the landmarks of \"%s\" and \"%s\" are not of one kind: flags are %x and %x; bits 0 and 2 "
        "(elevation, heights) must agree",
        a.name, b.name, a.info.flags, b.info.flags));
  }
  // Points of radars whose stamps were corrected lie beside those of radars that were as late.
  const double a_delay_s = StampDelayOf(a.info).value_or(0.0);
  const double b_delay_s = StampDelayOf(b.info).value_or(0.0);
  if (StampDelayOf(a.info).has_value() != StampDelayOf(b.info).has_value() &&
      std::max(std::abs(a_delay_s), std::abs(b_delay_s)) > kMaxIgnoredStampDelay_s) {
    return absl::FailedPreconditionError(absl::StrFormat(
        "the radars of one of \"%s\" and \"%s\" stamped their scans %.3f s late, and it is not "
        "known of the other one's: build that one anew",
        a.name, b.name, a_delay_s + b_delay_s));
  }
  const bool is_anchored = a.Anchor() && b.Anchor();
  const Pose3 T_a_b = is_anchored ? FrameChange(*a.Anchor(), *b.Anchor()) : Pose3();
  counts = {};
  EditableMap merged = a;
  if (!StampDelayOf(b.info)) SetStampDelay(std::nullopt, merged.info);
  std::map<PoseBits, std::size_t> known;
  for (std::size_t i = 0; i < a.keyframes.size(); ++i) {
    known.emplace(BitsOf(a.keyframes[i].record), i);
  }
  std::size_t doubled_candidates = 0;
  const Near near_a(a);
  for (const EditableKeyframe& keyframe : b.keyframes) {
    const KeyframeRecord record = InFrameOf(a, b, T_a_b, keyframe.record);
    const auto [found, is_new] = known.emplace(BitsOf(record), merged.keyframes.size());
    if (is_new) merged.keyframes.push_back({.record = record, .points = {}});
    std::vector<MapPoint>& points = merged.keyframes[found->second].points;
    std::set<PointBits> present;
    for (const MapPoint& point : points) present.insert(BitsOf(point));
    if (!is_new) ++counts.shared_keyframes;
    const Pose3 T_local_keyframe = PoseOf(record);
    for (const MapPoint& point : keyframe.points) {
      if (!present.insert(BitsOf(point)).second) {
        ++counts.shared_landmarks;
        continue;
      }
      points.push_back(point);
      const Eigen::Vector3d p_local = T_local_keyframe * PositionOf(point);
      if (near_a.HasOne(p_local.head<2>())) ++doubled_candidates;
    }
  }
  // Parts of one map have neighbours across their border, which are two scatterers.
  if (counts.shared_keyframes == 0) counts.doubled_landmarks = doubled_candidates;
  merged.info.length_m += ShareOfLength(b, b.keyframes.size() - counts.shared_keyframes);
  return merged;
}

}  // namespace dcloc
