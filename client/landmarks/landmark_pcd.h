#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client/landmarks/landmark_rows.h"

namespace dcloc {

/// Landmarks as a binary PCD v0.7 file. x, y, z are in the map frame minus the local origin, which
/// a comment names, because point clouds have single precision. All values of a landmark are
/// fields (`kPointFields`); `keyframe` is the number of its keyframe.
std::string FormatLandmarkPcd(const EditableMap& map);

/// The points of such a file, also after another tool has written it: ascii or binary, fields in
/// any order and of any type. Without the field `keyframe` all landmarks are new, their covariances
/// in the map frame. `origin_m` is the base map's local origin; `name` is for errors. DataLoss for
/// what is no PCD file or is cut short, Unimplemented for compressed data, InvalidArgument naming
/// the point, the field, the value and the bound.
absl::StatusOr<std::vector<LandmarkRow>> ParseLandmarkPcd(absl::string_view bytes,
                                                          absl::string_view name,
                                                          const Eigen::Vector3d& origin_m);

}  // namespace dcloc
