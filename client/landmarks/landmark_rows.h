#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/map/editable_map.h"

namespace dcloc {

/// A landmark as files of other tools show it: where it lies, and what of it they only carry along.
struct LandmarkRow {
  Eigen::Vector3d p_map;
  bool has_height = true;  ///< tools of the plane leave the height out; then it is as it was
  /// The number of its keyframe in the map that it was exported from; none for one that was drawn
  /// by hand.
  std::optional<std::uint32_t> keyframe;
  MapPoint point;    ///< in that keyframe's frame; without one, its covariance is in the map frame
  std::string name;  ///< for errors: the file and the row
};

/// All landmarks, in the map's order.
std::vector<LandmarkRow> RowsOf(const EditableMap& map);

/// What the rows of a file changed in a map.
struct LandmarkEdits {
  std::size_t same = 0;    ///< as in the map, to the last bit
  std::size_t moved = 0;   ///< by more than a centimetre
  std::size_t edited = 0;  ///< at its place, with other values
  std::size_t added = 0;
  std::size_t removed = 0;
};

/// `base` with the landmarks of `rows` in place of its own. A row within a centimetre of where its
/// `point` lies was not moved, and keeps the bits of `point`; other tools round positions. One that
/// was moved further than 120 m from its keyframe, or has none, joins the nearest keyframe.
/// InvalidArgument names the row, the field, the value and the bound; FailedPrecondition for no
/// row.
absl::StatusOr<EditableMap> ReplaceLandmarks(const EditableMap& base,
                                             const std::vector<LandmarkRow>& rows,
                                             LandmarkEdits& counts);

}  // namespace dcloc
