#include "core/map/map_builder.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_format.h"
#include "core/map/editable_map.h"
#include "core/map/keyframe_index.h"
#include "core/map/landmark_fusion.h"
#include "core/map/landmark_points.h"
#include "core/map/map_content.h"
#include "core/map/map_file.h"
#include "core/map/point_grid.h"

namespace dcloc {
namespace {

absl::Status CheckBound(const char* field, double value, double min, double max) {
  // Written so that NaN fails.
  if (value >= min && value <= max) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrFormat("%s is %g; it must lie in [%g, %g]", field, value, min, max));
}

absl::Status CheckText(const char* field, std::string_view text, std::size_t max_bytes) {
  if (IsMapText(text, max_bytes)) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrFormat("%s has %d bytes; it must be UTF-8 without NUL of at most %d", field,
                      text.size(), max_bytes));
}

absl::Status CheckPose(const Pose3& T_map_vehicle) {
  const double norm = T_map_vehicle.rotation.norm();
  if (!(std::abs(norm - 1.0) <= 1e-3)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("T_map_vehicle: rotation has the norm %g; it must be 1", norm));
  }
  return CheckBound("T_map_vehicle: translation_m", T_map_vehicle.translation_m.norm(), 0.0,
                    kMaxOrigin_m);
}

}  // namespace

std::span<const OptionField<MapBuilderOptions>> FieldsOf(const MapBuilderOptions& /*options*/) {
  using O = MapBuilderOptions;
  static constexpr OptionField<O> kFields[] = {
      {"keyframe_spacing_m", &O::keyframe_spacing_m, 0.5, 1000},
      {"max_keyframe_distance_m", &O::max_keyframe_distance_m, 1, 2000},
      {"stamp_delay_s", &O::stamp_delay_s, -0.5, 0.5, "no offset was corrected"},
  };
  return kFields;
}

absl::Status Validate(const MapBuilderOptions& options) {
  absl::Status status = CheckText("name", options.name, kMaxMapName_bytes);
  status.Update(CheckText("description", options.description, kMaxMapDescription_bytes));
  if (options.anchor) status.Update(Validate(*options.anchor));
  status.Update(ValidateFields(options, FieldsOf(options)));
  status.Update(Within("fusion", Validate(options.fusion)));
  status.Update(Within("static_points", Validate(options.static_points)));
  return status;
}

struct MapBuilder::Impl {
  Impl(Rig builder_rig, MapBuilderOptions builder_options)
      : rig(std::move(builder_rig)),
        options(std::move(builder_options)),
        keyframe_grid(options.keyframe_spacing_m) {}

  const Rig rig;
  const MapBuilderOptions options;

  std::optional<Eigen::Vector3d> local_origin_m;  ///< where the first pose lies in the map
  std::vector<MapReturn> returns;                 ///< in the order of their scans
  std::vector<std::uint32_t> pass_of_scan;
  std::uint32_t pass = 0;

  std::vector<Pose3> T_local_keyframes;
  PointGrid keyframe_grid;
  double length_m = 0.0;

  // Distance to the nearest keyframe, at most `limit_m`.
  double KeyframeDistance(const Eigen::Vector3d& p_local_m, double limit_m) const {
    double distance_m = limit_m;
    keyframe_grid.ForEachNear(
        p_local_m.head<2>(), Eigen::Vector2d::Constant(limit_m), [&](std::uint32_t i) {
          const Eigen::Vector3d offset_m = T_local_keyframes[i].translation_m - p_local_m;
          distance_m = std::min(distance_m, offset_m.head<2>().norm());
        });
    return distance_m;
  }

  // One rule for the first pass and the further ones, loops and the way back: a keyframe is made
  // where none is near.
  void AddKeyframeIfNoneIsNear(const Pose3& T_local_vehicle) {
    const double spacing_m = options.keyframe_spacing_m;
    const double distance_m = KeyframeDistance(T_local_vehicle.translation_m, 2.0 * spacing_m);
    if (distance_m < spacing_m) return;
    if (!T_local_keyframes.empty()) length_m += distance_m;
    T_local_keyframes.push_back(T_local_vehicle);
    keyframe_grid.Insert(T_local_vehicle.translation_m.head<2>());
  }

  void AddReturns(const std::vector<RadarPoint>& points, const Pose3& T_local_vehicle) {
    AppendReturns(points, T_local_vehicle, static_cast<std::uint32_t>(pass_of_scan.size()),
                  returns);
    pass_of_scan.push_back(pass);
  }

  std::vector<KeyframeRecord> KeyframeRecords() const {
    std::vector<KeyframeRecord> records;
    records.reserve(T_local_keyframes.size());
    for (const Pose3& T_local_keyframe : T_local_keyframes) {
      records.push_back(RecordOf(T_local_keyframe));
    }
    return records;
  }

  bool HasHeights() const {
    return !rig.MeasuresElevation() && options.fusion.height_square_sigma_m2 > 0.0;
  }

  // The points in the order of their keyframes, whose records learn which are theirs.
  std::vector<MapPoint> ShareOut(const std::vector<Landmark>& landmarks, const KeyframeIndex& index,
                                 std::vector<KeyframeRecord>& keyframes) const {
    std::vector<std::pair<std::size_t, std::size_t>> owned;  // (keyframe, landmark)
    for (std::size_t i = 0; i < landmarks.size(); ++i) {
      const std::optional<std::size_t> keyframe =
          index.Nearest(landmarks[i].position_m.head<2>(), options.max_keyframe_distance_m);
      if (keyframe) owned.emplace_back(*keyframe, i);
    }
    std::ranges::sort(owned);
    std::vector<MapPoint> points;
    points.reserve(owned.size());
    for (const auto& [keyframe, landmark] : owned) {
      ++keyframes[keyframe].point_count;
      points.push_back(
          PointInKeyframe(landmarks[landmark], T_local_keyframes[keyframe], HasHeights()));
    }
    for (std::size_t i = 1; i < keyframes.size(); ++i) {
      keyframes[i].first_point = keyframes[i - 1].first_point + keyframes[i - 1].point_count;
    }
    return points;
  }

  InfoRecord Info() const {
    InfoRecord info{};
    Eigen::Vector3d::Map(info.local_origin_m.data()) = *local_origin_m;
    info.length_m = length_m;
    info.index_cell_m = kIndexCell_m;
    info.name_size_bytes = static_cast<std::uint32_t>(options.name.size());
    info.flags = rig.MeasuresElevation() ? kHasElevationFlag : 0;
    if (HasHeights()) info.flags |= kHasHeightsFlag;
    if (rig.HasKnownStamps()) SetStampDelay(options.stamp_delay_s, info);
    SetAnchor(options.anchor, info);
    return info;
  }
};

MapBuilder::MapBuilder(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
MapBuilder::MapBuilder(MapBuilder&&) noexcept = default;
MapBuilder& MapBuilder::operator=(MapBuilder&&) noexcept = default;
MapBuilder::~MapBuilder() = default;

absl::StatusOr<MapBuilder> MapBuilder::Create(Rig rig, MapBuilderOptions options) {
  absl::Status status = Validate(rig);
  status.Update(Validate(options));
  if (!status.ok()) return status;
  return MapBuilder(std::make_unique<Impl>(std::move(rig), std::move(options)));
}

absl::Status MapBuilder::Add(const Scan& scan, const Pose3& T_map_vehicle,
                             const EgoVelocity& ego_velocity) {
  absl::Status status = Validate(scan);
  status.Update(Validate(ego_velocity));
  status.Update(CheckPose(T_map_vehicle));
  if (!status.ok()) return status;
  const RadarModel* const radar = impl_->rig.Find(scan.radar_id);
  if (radar == nullptr) {
    return absl::InvalidArgumentError(
        absl::StrFormat("radar_id is \"%s\"; the rig has no such radar", scan.radar_id));
  }
  const Eigen::Vector3d origin_m = impl_->local_origin_m.value_or(T_map_vehicle.translation_m);
  const Pose3 T_local_vehicle{.translation_m = T_map_vehicle.translation_m - origin_m,
                              .rotation = T_map_vehicle.rotation.normalized()};
  status = CheckBound("T_map_vehicle: distance_m from the first pose",
                      T_local_vehicle.translation_m.norm(), 0.0, kMaxLocal_m);
  if (!status.ok()) return status;

  impl_->local_origin_m = origin_m;
  impl_->AddKeyframeIfNoneIsNear(T_local_vehicle);
  impl_->AddReturns(StaticPoints(scan, *radar, ego_velocity, impl_->options.static_points),
                    T_local_vehicle);
  return absl::OkStatus();
}

void MapBuilder::BeginPass() { ++impl_->pass; }

absl::StatusOr<std::vector<std::byte>> MapBuilder::Build() const {
  const std::vector<Landmark> landmarks = FuseLandmarks(
      impl_->returns, impl_->pass_of_scan, impl_->rig.MeasuresElevation(), impl_->options.fusion);
  std::vector<KeyframeRecord> keyframes = impl_->KeyframeRecords();
  const std::vector<IndexRecord> index = MakeIndex(keyframes, kIndexCell_m);
  const std::vector<MapPoint> points =
      impl_->ShareOut(landmarks, KeyframeIndex(index, keyframes, kIndexCell_m), keyframes);
  if (points.empty()) {
    return absl::FailedPreconditionError(absl::StrFormat(
        "%d scans with %d static returns gave no landmark that %d scans saw",
        impl_->pass_of_scan.size(), impl_->returns.size(), impl_->options.fusion.min_scan_count));
  }
  return WriteMapFile({.info = impl_->Info(),
                       .name = impl_->options.name,
                       .description = impl_->options.description,
                       .keyframes = keyframes,
                       .index = index,
                       .points = points});
}

}  // namespace dcloc
