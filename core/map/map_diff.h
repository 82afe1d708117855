#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "core/map/editable_map.h"
#include "core/options/option_fields.h"

namespace dcloc {

struct MapDiffOptions {
  double same_m = 0.5;      ///< landmarks of two maps that are nearer are one
  double moved_m = 2.0;     ///< of those left over, nearer ones have moved
  double covered_m = 60.0;  ///< ground further from every keyframe of a map is not covered by it
};
std::span<const OptionField<MapDiffOptions>> FieldsOf(const MapDiffOptions& options);
absl::Status Validate(const MapDiffOptions& options);

/// A landmark that only one of two maps has, in the old map's frame.
struct LandmarkChange {
  Eigen::Vector3d p_map;
  float rcs_dbsm = 0.0F;
  int scan_count = 0;
  int pass_count = 0;
};

struct LandmarkMove {
  LandmarkChange before;
  LandmarkChange after;
};

/// What two maps of one place differ by, where both cover the ground.
struct MapDiff {
  std::vector<LandmarkChange> added;
  std::vector<LandmarkChange> removed;
  std::vector<LandmarkMove> moved;
  std::vector<LandmarkChange> same;       ///< that both have, as the old map has them
  double same_rms_m = 0.0;                ///< of the distances between those in the plane
  std::size_t only_old_covers_count = 0;  ///< landmarks of the old map where the new covers nothing
  std::size_t only_new_covers_count = 0;  ///< likewise
  Pose3 T_old_new;                        ///< of the map frames, by the anchors
};

/// Pairs landmarks one to one by distance in the plane, nearest first. The frames pass
/// `CheckFrames`. InvalidArgument for invalid options.
absl::StatusOr<MapDiff> Compare(const EditableMap& old_map, const EditableMap& new_map,
                                const MapDiffOptions& options);

}  // namespace dcloc
