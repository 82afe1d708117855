#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/map/editable_map.h"
#include "core/mapping/drive_source.h"
#include "core/passes/placed_pass.h"
#include "core/update/map_update.h"
#include "core/versions/update_gate.h"

namespace dcloc {

/// The drives of an update.
struct UpdateDrives {
  DriveSource& source;  ///< three drives at least, with different names
  /// Whose each drive is. Empty: those whose radars are mounted alike are of one vehicle.
  std::vector<std::string> vehicles;
  std::size_t held_out = 0;  ///< judges the new version, and has no part in it
};

/// A new version of a map, and whether it is better.
struct JudgedUpdate {
  std::vector<PlacedPass> passes;   ///< without their points, and without the one that was held out
  std::vector<std::string> faults;  ///< of each pass; empty where it is of use
  std::string held_out;             ///< its name
  MapUpdate update;
  UpdateEvaluation gate;
  bool has_only_new_streets = false;  ///< the rest was worse, and stays as it was
};

/// Gets the stage and the share of it that is done; returning false ends the work with Cancelled.
using UpdateProgress = std::function<bool(const std::string& stage, double share)>;

/// Localizes drives in the base map, makes a new version of all that are of use but one, and judges
/// it by that one. Drives are read one at a time; of each only what an update
/// needs is kept. FailedPrecondition where fewer than two drives are of use, and says why of each.
/// Errors name the drive. That the new version is worse is no error: `gate` says so.
absl::StatusOr<JudgedUpdate> BuildUpdate(const EditableMap& base, const UpdateDrives& drives,
                                         const MapUpdateOptions& options,
                                         const UpdateProgress& progress);

/// By what a version was judged, for its description.
std::string DescribeJudgement(const JudgedUpdate& update);

}  // namespace dcloc
