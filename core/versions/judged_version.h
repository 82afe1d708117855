#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "absl/status/statusor.h"
#include "core/map/editable_map.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"
#include "core/update/map_update.h"
#include "core/versions/update_gate.h"

namespace dcloc {

/// A new version of a map that was judged, and what of it was left out for that.
struct JudgedVersion {
  EditableMap map;
  UpdateEvaluation evaluation;        ///< of `map`
  bool has_only_new_streets = false;  ///< the old version's keyframes are as they were
  std::vector<bool> is_kept;  ///< of each keyframe of the version as it came: it is as it came
};

/// Evaluates a new version (`EvaluateUpdate`). One that is refused and has new streets is evaluated
/// again with these alone: all that the old version has stays as it was, and new streets that are
/// refused are left out. The update's map has the old version's keyframes, and those of new streets
/// after them. Errors are those of `EvaluateUpdate`.
absl::StatusOr<JudgedVersion> JudgeVersion(const EditableMap& old_version, const MapUpdate& update,
                                           const Rig& rig, const std::vector<Scan>& scans,
                                           const UpdateGateOptions& options = {});

/// Where an update found that things come and go, relative to the map's local origin.
std::vector<Eigen::Vector2d> IntermittentPlaces(const MapUpdate& update);

}  // namespace dcloc
