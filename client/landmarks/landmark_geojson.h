#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client/landmarks/landmark_rows.h"
#include "core/geometry/geodetic_anchor.h"

namespace dcloc {

/// Landmarks as GeoJSON (RFC 7946): a point feature each, on a line of its own, in WGS 84 with the
/// height over the ellipsoid; all values of a landmark are its properties (`kPointFields`).
/// FailedPrecondition for a map without an anchor.
absl::StatusOr<std::string> FormatLandmarkGeoJson(const EditableMap& map);

/// The point features of such a file, also after another tool has written it. A feature without
/// the property `keyframe` is a new landmark; it has the covariance in the map frame, and without a
/// third coordinate the anchor's height. `name` is for errors: DataLoss for what is no GeoJSON,
/// InvalidArgument naming the feature, the property, the value and the bound, or how deep the file
/// is nested.
absl::StatusOr<std::vector<LandmarkRow>> ParseLandmarkGeoJson(absl::string_view text,
                                                              absl::string_view name,
                                                              const GeodeticAnchor& anchor);

}  // namespace dcloc
