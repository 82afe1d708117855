#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/geometry/planar_region.h"
#include "core/map/editable_map.h"

namespace dcloc::cli {

/// A region as it was written; the union of all its parts.
struct RegionArguments {
  PlanarRegion in_map;               ///< of --box and --polygon
  std::vector<std::string> geojson;  ///< files of --region
};

/// Adds --box and --polygon, in the map frame, and --region, a GeoJSON file in WGS 84. At least one
/// is needed.
void AddRegionOptions(CLI::App& command, RegionArguments& arguments);

/// The region in the map's frame. FailedPrecondition for a GeoJSON file where the map has no
/// anchor; other errors name the file.
absl::StatusOr<PlanarRegion> RegionOf(const RegionArguments& arguments, const EditableMap& map);

}  // namespace dcloc::cli
