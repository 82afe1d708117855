#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/geometry/geodetic_anchor.h"
#include "core/map/keyframe_index.h"
#include "core/map/landmark_fusion.h"
#include "core/options/option_fields.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"
#include "core/radar/static_points.h"

namespace dcloc {

struct MapBuilderOptions {
  std::string name;
  std::string description;
  std::optional<GeodeticAnchor> anchor;
  /// By how much the time offsets of the rig were corrected, on average, against its description.
  double stamp_delay_s = 0.0;
  StaticPointsOptions static_points;
  double keyframe_spacing_m = 10.0;
  FusionOptions fusion;
  /// Landmarks further from any keyframe are left out.
  double max_keyframe_distance_m = kMaxKeyframeDistance_m;
};
std::span<const OptionField<MapBuilderOptions>> FieldsOf(const MapBuilderOptions& options);

/// OK, or InvalidArgument that names the field, the value and the bound.
absl::Status Validate(const MapBuilderOptions& options);

/// Makes a map from scans at known vehicle poses. Deterministic: the same calls give the same
/// bytes.
class MapBuilder {
 public:
  static absl::StatusOr<MapBuilder> Create(Rig rig, MapBuilderOptions options);
  MapBuilder(MapBuilder&&) noexcept;
  MapBuilder& operator=(MapBuilder&&) noexcept;
  ~MapBuilder();

  /// Adds one scan taken at `T_map_vehicle`. The map's frame is the frame of these poses.
  /// InvalidArgument for an invalid scan, an unknown radar or a pose that is not finite.
  absl::Status Add(const Scan& scan, const Pose3& T_map_vehicle, const EgoVelocity& ego_velocity);

  /// The scans added from now on are a further drive over the same ground. Landmarks count the
  /// passes that saw them.
  void BeginPass();

  /// The map file's bytes, for RadarMap::FromBytes or to be written to a file. FailedPrecondition
  /// when there is no landmark that enough scans saw.
  absl::StatusOr<std::vector<std::byte>> Build() const;

 private:
  struct Impl;
  explicit MapBuilder(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace dcloc
