#pragma once

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "core/geometry/geodetic_anchor.h"
#include "core/geometry/planar_region.h"

namespace dcloc {

/// The polygons of a GeoJSON text in WGS 84 (a geometry, feature or collection of them), as a
/// region in the frame of a map with `anchor`. Other geometries are refused. Edges are straight in
/// longitude and latitude (RFC 7946): they are cut to at most 500 m. `name` is for errors:
/// DataLoss, InvalidArgument naming the position. No position lies further than 500 km from the
/// anchor.
absl::StatusOr<PlanarRegion> ParseRegionGeoJson(absl::string_view text, absl::string_view name,
                                                const GeodeticAnchor& anchor);

}  // namespace dcloc
