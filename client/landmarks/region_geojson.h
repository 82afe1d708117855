#pragma once

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "core/geometry/geodetic_anchor.h"
#include "core/geometry/planar_region.h"

namespace dcloc {

/// The polygons of a GeoJSON text in WGS 84 (a geometry, feature or collection of them), as a
/// region in the frame of a map with `anchor`. Other geometries are refused. Edges are straight in
/// the map. `name` is for errors: DataLoss, InvalidArgument naming the position.
absl::StatusOr<PlanarRegion> ParseRegionGeoJson(absl::string_view text, absl::string_view name,
                                                const GeodeticAnchor& anchor);

}  // namespace dcloc
