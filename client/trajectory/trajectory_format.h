#pragma once

#include <array>
#include <filesystem>
#include <utility>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace dcloc {

/// How a trajectory is written:
///  - TUM: `stamp x y z qx qy qz qw` a line, the stamp in seconds;
///  - KITTI: the upper three rows of T_map_vehicle a line, row by row, without stamps;
///  - CSV: a header and a line a pose, with latitude, longitude, height and heading where there is
///    an anchor;
///  - GeoJSON (RFC 7946): a line string with `coordTimes`, and GPX 1.1: a track; both need an
///    anchor.
enum class TrajectoryFormat { kTum, kKitti, kCsv, kGeoJson, kGpx };

/// The formats by the names that users write.
inline constexpr std::array<std::pair<const char*, TrajectoryFormat>, 5> kTrajectoryFormatNames = {
    {{"tum", TrajectoryFormat::kTum},
     {"kitti", TrajectoryFormat::kKitti},
     {"csv", TrajectoryFormat::kCsv},
     {"geojson", TrajectoryFormat::kGeoJson},
     {"gpx", TrajectoryFormat::kGpx}}};

/// The format called `name`, or where that is empty the one of the path's extension (`.json` is
/// GeoJSON). InvalidArgument names the path or the name, and the formats that there are.
absl::StatusOr<TrajectoryFormat> TrajectoryFormatOf(const std::filesystem::path& path,
                                                    absl::string_view name);

/// Whether the format has places on the Earth only.
bool NeedsAnchor(TrajectoryFormat format);

}  // namespace dcloc
