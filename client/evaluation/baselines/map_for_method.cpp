#include "client/evaluation/baselines/map_for_method.h"

#include <utility>
#include <vector>

#include "client/datasets/drive_map.h"
#include "client/evaluation/baselines/ego_range_rates.h"

namespace dcloc {

absl::StatusOr<std::shared_ptr<const RadarMap>> MapForMethod(
    MethodKind kind, const Drive& drive, const LocalizerOptions& options, bool has_heights,
    const std::function<void(std::size_t)>& progress) {
  MapBuilderOptions map_options;
  map_options.name = drive.name;
  map_options.static_points = options.static_points;
  map_options.static_points.compensate = options.doppler_compensation;
  map_options.static_points.per_point_covariance = options.per_point_covariance;
  // Others know nothing of heights: landmarks stay where slant ranges show them.
  if (!RunsInLocalizer(kind) || !has_heights) map_options.fusion.height_square_sigma_m2 = 0.0;
  absl::StatusOr<std::vector<std::byte>> bytes;
  if (RunsInLocalizer(kind)) {
    bytes = BuildMap(drive, map_options, progress);
  } else {  // others correct no stamps, neither live nor in the map
    Drive as_described = kind == MethodKind::kMcRansac ? WithEgoRangeRates(drive) : drive;
    for (RadarModel& radar : as_described.rig.radars) radar.time_offset_sigma_s = 0.0;
    bytes = BuildMap(as_described, map_options, progress);
  }
  if (!bytes.ok()) return bytes.status();
  return RadarMap::FromBytes(*std::move(bytes));
}

}  // namespace dcloc
