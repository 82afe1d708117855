#pragma once

#include <cstddef>
#include <vector>

#include "absl/status/statusor.h"
#include "core/map/editable_map.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"
#include "core/update/street_segments.h"
#include "core/update/update_gate.h"

namespace dcloc {

/// A new version that was judged, without what was worse.
struct VersionByStreet {
  EditableMap map;
  UpdateEvaluation evaluation;  ///< of `map`
  StreetSegments segments;      ///< of the version as it came
  std::vector<bool> is_left;    ///< of each of these: it stays as it was
  std::size_t left_count = 0;
};

/// Evaluates a new version (`EvaluateUpdate`). Street segments that are worse get back what the old
/// version had there, and nothing where it had none, and what comes out is evaluated again.
/// `new_version` has the old version's keyframes, and others after them. Errors are those of
/// `EvaluateUpdate`.
absl::StatusOr<VersionByStreet> JudgeStreetByStreet(const EditableMap& old_version,
                                                    const EditableMap& new_version, const Rig& rig,
                                                    const std::vector<Scan>& scans,
                                                    const UpdateGateOptions& options = {});

}  // namespace dcloc
